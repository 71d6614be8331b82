"""What comes through a Slurm of this machine is what comes without."""

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


@pytest.mark.parametrize(
    ("target", "least"),
    [
        ("results/smoke/sim_to_real/identification.parquet", 20),
        # both chains, every job: ten minutes
        pytest.param("all", 100, marks=pytest.mark.slow),
    ],
)
def test_slurm_gives_the_same_results_and_takes_short_jobs_together(tmp_path, smoke, target, least):
    project = Project(tmp_path)
    try:
        with cluster.running():
            done = project.run(
                *("--profile", str(project.folder / "workflow/profiles/slurm")),
                *("--slurm-no-account", "--slurm-status-command", "squeue"),
                *("--", target),
            )
    except cluster.CannotStartError as error:
        pytest.skip(f"no Slurm here: {error}")
    assert done.returncode == 0, done.stdout[-6000:]

    made = {path for path in project.artefacts() if comparable(path)}
    assert len(made) >= least
    if target == "all":
        assert made == {path for path in smoke.artefacts() if comparable(path)}
    for path in sorted(made):
        assert_same(project.results / path, smoke.results / path)

    planned = int(next(line for line in done.stdout.splitlines() if " jobs: " in line).split()[0])
    assert done.stdout.count("has been submitted with SLURM jobid") < planned / 2
    assert f"{planned} of {planned}" in done.stdout


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
