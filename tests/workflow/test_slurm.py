"""What comes through a Slurm of this machine is what comes without."""

import pytest

from tests.slurm import cluster
from tests.workflow.conftest import Project
from tests.workflow.same import assert_same, comparable


@pytest.mark.parametrize(
    ("target", "least"),
    [
        ("results/smoke/sim_to_real/identification.parquet", 10),
        # both chains, every job: ten minutes
        pytest.param("all", 80, marks=pytest.mark.slow),
    ],
)
def test_slurm_gives_the_same_results_and_takes_short_jobs_together(tmp_path, smoke, target, least):
    project = Project(tmp_path)
    try:
        with cluster.running():
            done = project.run(
                *("--profile", str(project.folder / "profiles/slurm")),
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
