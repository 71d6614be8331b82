"""Both chains through a Slurm of this machine give what they give without."""

import os

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.slurm import cluster
from tests.workflow.conftest import Project

# how long something took, which no two runs share
TIMED = {"seconds"}
READERS = {".parquet": pd.read_parquet, ".csv": pd.read_csv}


@pytest.fixture(scope="module")
def through_slurm(tmp_path_factory):
    project = Project(tmp_path_factory.mktemp("slurm"))
    try:
        with cluster.running():
            project.first = project.run(
                *("--profile", str(project.folder / "workflow/profiles/slurm")),
                *("--slurm-no-account", "--slurm-status-command", "squeue"),
                *("--", "all"),
            )
    except cluster.CannotStartError as error:
        pytest.skip(f"no Slurm here: {error}")
    assert project.first.returncode == 0, project.first.stdout[-6000:]
    return project


def test_results_are_the_same_as_without(through_slurm, smoke):
    here, there = ({p for p in q.artefacts() if comparable(p)} for q in (through_slurm, smoke))
    assert here == there
    assert len(here) > 100
    for path in sorted(here):
        assert_same(through_slurm.results / path, smoke.results / path)


def test_short_jobs_go_together_and_each_is_counted(through_slurm):
    lines = through_slurm.first.stdout.splitlines()
    submitted = sum("has been submitted with SLURM jobid" in line for line in lines)
    planned = int(next(line for line in lines if " jobs: " in line).split()[0])
    assert submitted < 0.7 * planned
    assert f"{planned} of {planned}" in through_slurm.first.stdout


def comparable(path: str) -> bool:
    """Numbers: pictures carry dates, journals the names of processes."""
    return os.path.splitext(path)[1] in {*READERS, ".yaml", ".npz", ".md", ".tex"}


def assert_same(path, other):
    if path.suffix in READERS:
        ours, theirs = (READERS[path.suffix](p) for p in (path, other))
        kept = [column for column in theirs if column not in TIMED]
        pd.testing.assert_frame_equal(ours[kept], theirs[kept], obj=str(path))
    elif path.suffix == ".npz":
        with np.load(path) as ours, np.load(other) as theirs:
            assert ours.files == theirs.files, path
            for name in ours.files:
                np.testing.assert_array_equal(ours[name], theirs[name], err_msg=str(path))
    elif path.suffix == ".yaml":
        assert yaml.safe_load(path.read_text()) == yaml.safe_load(other.read_text()), path
    else:
        assert path.read_text() == other.read_text(), path
