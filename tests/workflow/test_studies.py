"""Studies that ship can be planned, from the files of the project alone."""

import json
import re

import pytest

# those whose rules or sections no other has; that all of them can be read is tested elsewhere
JOBS = {"config": 80, "landscape": 1155, "paper": 6408, "transfer_decision": 473, "variants": 1520}


def _planned(done):
    assert done.returncode == 0, done.stdout
    return int(re.search(r"^total +(\d+)$", done.stdout, re.MULTILINE)[1])


def test_the_default_study_needs_no_flag(empty_project):
    assert _planned(empty_project.run_default("--dry-run")) == JOBS["config"]


@pytest.mark.parametrize(
    "name",
    # the largest alone takes as long as all others
    ["landscape", pytest.param("paper", marks=pytest.mark.slow), "transfer_decision", "variants"],
)
def test_a_study_is_planned_whole(empty_project, name):
    file = f"config/studies/{name}.yaml"
    assert _planned(empty_project.run_default("--dry-run", "--configfile", file)) == JOBS[name]


def test_the_profile_of_a_gpu_trains_all_policies_in_one_job(empty_project):
    profile = str(empty_project.folder / "profiles/gpu")
    done = empty_project.run_default("--dry-run", "--profile", profile)
    # six cloned policies; trials and policies of two cells
    assert _planned(done) == JOBS["config"] - 5 - 1 - 1
    jobs = {"train_side_by_side": 1, "tune_joint_reach": 1, "train_policy_joint_reach": 1}
    for rule, count in jobs.items():
        assert re.search(rf"^{rule} +{count}$", done.stdout, re.MULTILINE)


def test_tasks_that_the_study_has_are_compared_with_its_grids_where_these_are_given(empty_project):
    name, config = "published_grids", empty_project.config
    page = {"kps": [32], "kds": [2], "validation": [[0.1]], "replay": [[1]], "loss": [[0.2]]}
    path = empty_project.folder / "page.json"
    path.write_text(json.dumps({"taskData": {"Dishwasher Opening": page}}))
    given = config["attenuation"] | {"published_grids": "page.json"}
    tasks = ["block_stack", "dishwasher"]
    both = {**config, "tasks": tasks, "attenuation": given}
    planned = empty_project.planned("tables", config=both)
    assert (planned[name], planned["summarise"]) == (1, 2)
    # of both tasks, the table takes the one that the study has
    csv = f"results/smoke/tables/{name}.csv"
    assert empty_project.planned(csv, config=both)["summarise"] == 1
    for without in ({**both, "tasks": tasks[:1]}, {**config, "tasks": tasks}):
        assert name not in empty_project.planned("tables", config=without)


def test_more_collections_leave_the_first_as_it_is(empty_project):
    config = {**empty_project.config, "collections": 2}
    once, twice = (
        empty_project.planned("tables", config=c) for c in (empty_project.config, config)
    )
    for rule, more in (("demonstrate", 1), ("train", once["train"])):
        assert twice[rule] - once.get(rule, 0) == more
    assert (once.get("collections", 0), twice["collections"]) == (0, 1)
    folder = "results/smoke/block_stack/collection1/nominal"
    assert empty_project.planned(f"{folder}/cells.parquet", config=config)["demonstrate"] == 1
