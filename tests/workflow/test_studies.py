"""Every study that ships can be planned, from the files of the project alone."""

import re

import pytest

from tests.conftest import ROOT

JOBS = {
    "config": 166, "decoupling": 83, "joint_deltas": 76, "landscape": 196,
    "landscape_references": 313, "paper": 3825, "smoke": 70, "transfer_conditions": 330,
    "transfer_decision": 414, "transfer_grid": 325, "transfer_rates": 482, "ur5e": 121,
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
