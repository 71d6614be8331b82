"""Every study that ships can be planned, from the files of the project alone."""

import re

import pytest

from tests.conftest import ROOT

JOBS = {
    "config": 163, "joint_deltas": 74, "paper": 3822, "smoke": 64, "transfer_conditions": 327,
    "transfer_decision": 411, "transfer_grid": 322, "transfer_rates": 479, "ur5e": 118,
}  # fmt: skip


def _planned(done):
    assert done.returncode == 0, done.stdout
    return int(re.search(r"^total +(\d+)$", done.stdout, re.MULTILINE)[1])


def test_the_default_study_needs_no_flag(empty_project):
    assert _planned(empty_project.run_default("--dry-run")) == JOBS["config"]


@pytest.mark.parametrize(
    "name", sorted(path.stem for path in (ROOT / "config/studies").glob("*.yaml"))
)
def test_a_study_is_planned_whole(empty_project, name):
    file = f"config/studies/{name}.yaml"
    assert _planned(empty_project.run_default("--dry-run", "--configfile", file)) == JOBS[name]
