"""Killed twenty times at random moments, a study comes to what it comes to undisturbed."""

import os
import shutil
import signal
import subprocess

import numpy as np
import pytest

from tests.workflow.conftest import Project
from tests.workflow.same import TIMED, assert_same, comparable

KILLS = 20
# a trial that is run again gets a number of its own
NUMBERED = {"number", "trial"}


@pytest.mark.slow
def test_twenty_kills_change_no_number(tmp_path, smoke):
    project, rng = Project(tmp_path), np.random.default_rng(0)
    for _ in range(KILLS):
        run = subprocess.Popen(
            project.command("--", "all"),
            cwd=project.folder,
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            # Snakemake itself starts for three seconds; the longest job takes twenty
            run.wait(timeout=rng.uniform(1, 30))
            shutil.rmtree(project.results)
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
    done = project.run("--", "all")
    assert done.returncode == 0, done.stdout[-6000:]
    made = {path for path in project.artefacts() if comparable(path)}
    assert made == {path for path in smoke.artefacts() if comparable(path)}
    assert not [path for path in project.results.rglob("*") if ".draft-" in path.name]
    for path in sorted(made):
        assert_same(project.results / path, smoke.results / path, TIMED | NUMBERED)
