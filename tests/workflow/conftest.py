import multiprocessing
import os
import re
import shutil
import sys
from types import SimpleNamespace

import pytest
import yaml

from tests.conftest import ROOT, configuration

# importing Snakemake takes longer than planning a study; here it is imported once
STARTED = multiprocessing.get_context("forkserver")
STARTED.set_forkserver_preload(["snakemake.cli"])


def _snakemake(arguments, folder, environment, output):
    """`python -m snakemake`, in a process of its own, with both streams in a file."""
    from snakemake.cli import main

    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:0] = [str(folder), *environment.get("PYTHONPATH", "").split(os.pathsep)]
    with open(output, "wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    main(arguments)


class Project:
    """A copy of the workflow in a folder of its own, or of a project that has run."""

    def __init__(self, folder, like=None):
        self.folder = folder
        if like:
            # with its modification times and Snakemake's records, so that nothing is outdated
            shutil.copytree(like.folder, folder, symlinks=True, dirs_exist_ok=True)
        else:
            for name in ("workflow", "config", "profiles"):
                shutil.copytree(ROOT / name, folder / name)
            shutil.copy(ROOT / "Snakefile", folder)
            # recordings that config.yaml names
            (folder / "examples").symlink_to(ROOT / "examples")
        self.config = configuration("studies/smoke")
        self.results = folder / "results" / "smoke"

    def arguments(self, *arguments, config=None):
        path = self.folder / "test.yaml"
        path.write_text(yaml.safe_dump(config or self.config))
        return ["--cores", "2", "--configfile", str(path), *arguments]

    def command(self, *arguments, config=None):
        return [sys.executable, "-m", "snakemake", *self.arguments(*arguments, config=config)]

    def run(self, *arguments, config=None):
        return self._run(self.arguments(*arguments, config=config))

    def run_default(self, *arguments):
        """Without naming a configuration."""
        return self._run(["--cores", "2", *arguments])

    def _run(self, arguments):
        output = self.folder / ".output"
        run = STARTED.Process(
            target=_snakemake, args=(arguments, self.folder, dict(os.environ), output)
        )
        run.start()
        run.join()
        return SimpleNamespace(returncode=run.exitcode, stdout=output.read_text())

    def planned(self, *targets, config=None):
        """How many jobs of each rule a run would start."""
        done = self.run("--dry-run", "--", *(targets or ["all"]), config=config)
        assert done.returncode == 0, done.stdout
        stats = (
            done.stdout.split("Job stats:")[1].split("total")[0]
            if "Job stats:" in done.stdout
            else ""
        )
        return {rule: int(n) for rule, n in re.findall(r"^(\w+) +(\d+)$", stats, re.MULTILINE)}

    def artefacts(self):
        return {
            str(p.relative_to(self.results)): p.stat().st_mtime_ns
            for p in self.results.rglob("*")
            # every run writes the mark anew
            if p.is_file()
            and not {"logs", "benchmarks", ".t2l"} & set(p.relative_to(self.results).parts)
        }


@pytest.fixture
def empty_project(tmp_path):
    return Project(tmp_path)


@pytest.fixture
def copied(smoke, tmp_path):
    """A copy of the smoke run, to be changed."""
    return Project(tmp_path / "copy", like=smoke)


@pytest.fixture(scope="session")
def smoke(tmp_path_factory):
    """The smoke configuration, run once and left as it is."""
    project = Project(tmp_path_factory.mktemp("smoke"))
    project.first = project.run("--", "all")
    assert project.first.returncode == 0, project.first.stdout[-6000:]
    return project
