import copy

import pytest
import yaml


def _set(config, path, value):
    config = copy.deepcopy(config)
    *parents, key = path.split(".")
    section = config
    for parent in parents:
        section = section[parent]
    section[key] = value
    return config


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("grid.kp", [0, 32], "grid.kp[0]: found 0; allowed: a number above 0"),
        ("grid.kd", [], "grid.kd: found []; allowed: a list with at least 1 element"),
        ("tasks", ["block_stck"], "found 'block_stck' (did you mean block_stack?)"),
        ("training.epoch", 3, "training.epoch: found an unknown key (did you mean epochs?)"),
        ("demonstrations.count", 0, "demonstrations.count: found 0; allowed: a number from 2 up"),
    ],
)
def test_a_bad_configuration_stops_before_the_first_job(empty_project, path, value, message):
    done = empty_project.run("--", "all", config=_set(empty_project.config, path, value))
    assert done.returncode != 0
    assert message in done.stdout
    assert "Traceback" not in done.stdout
    assert not empty_project.results.exists()


def test_an_expert_that_fails_says_its_rate(empty_project):
    path = empty_project.folder / "config/tasks/block_stack.yaml"
    task = yaml.safe_load(path.read_text())
    # nobody stacks to a micrometre
    path.write_text(yaml.safe_dump({**task, "placement_tolerance_m": 1e-6}))
    done = empty_project.run("--", "results/smoke/tables/behaviour_cloning.csv")
    assert done.returncode != 0
    assert "the expert succeeded in 0 of 20 attempts (0 %), 8 successes are wanted" in done.stdout
    assert not (empty_project.results / "block_stack" / "demonstrations").exists()
