import pytest

from t2l.config import read_study
from t2l.registry import load_extensions
from tests.conftest import ROOT


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        ("grid", {"compliant_up_to_kp": 1}, "put 0 of 16 cells"),
        ("demonstrations", {"max_attempts": 10}, "at least demonstrations.count = 100"),
        (
            "operator",
            {"reaction_s": 2},
            "operator.reaction_s: found 2; allowed: a number up to 1",
        ),
        (
            "operator",
            {"motor_nose": 0.1},
            "operator.motor_nose: found an unknown key (did you mean",
        ),
        ("operator", {"motor_noise": -1}, "operator.motor_noise: found -1; allowed: a number from"),
        (
            "operator",
            {"crossover_rad_s": []},
            "operator.crossover_rad_s: found []; allowed: a list",
        ),
        (
            "operator",
            {"reaction_s": 0.5, "crossover_rad_s": [1, 2, 3, 4]},
            "operator.crossover_rad_s[3]: found 4; allowed: a number below π/2 / "
            "operator.reaction_s = 3.142",
        ),
        (
            "operator",
            {"practice": 500, "crossover_rad_s": [1, 2, 3, 4, 5, 6]},
            "horizon_s of a task: found 6 × 500 × 8; allowed: a product of at most 20000",
        ),
        (
            "actions",
            {"kind": "joint_delta", "rotation": {"kp": 2}},
            "actions.rotation: found {'kp': 2, 'kd': 1.0}; allowed: no such key with joint_delta",
        ),
        ("retargeting", {"policy_rate_hz": 60}, "a divisor of the simulation's 500 Hz"),
        ("fidelity", {"replays": 101}, "at most demonstrations.count = 80"),
        ("training", {"validation_fraction": 0.999}, "leaves demonstrations to train on"),
        ("rollouts", {"executed_actions": 11}, "at most training.chunk = 10"),
        ("identification", {"rate_hz": 75}, "a multiple of the recordings' 50 Hz"),
        (
            "deployment",
            {"workspace_lower_m": [-1, -1, 1.5]},
            "deployment.workspace_lower_m[2]: found 1.5; allowed: a number below "
            "workspace_upper_m[2] = 1.19",
        ),
        (
            "deployment",
            {"workspace_upper_m": [1, 1, 0]},
            "deployment.workspace_upper_m[2]: found 0; allowed: a number above "
            "workspace_lower_m[2] = 0.02",
        ),
        (
            "deployment",
            {"workspace_lower_m": [0, 0, 0], "workspace_upper_m": [1, 0, 1]},
            "deployment.workspace_lower_m[1]: found 0; allowed: a number below",
        ),
    ],
)
def test_what_cannot_run_is_named(config, refused, section, keys, message):
    config[section] = keys
    assert message in refused(config)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"name": "joint_reach"}, "[1].name: found 'joint_reach' a second time; allowed: names"),
        ({"task": "joint_rech"}, "[1].task: found 'joint_rech' (did you mean joint_reach?)"),
        ({"policy_rate_hz": 30}, "[1].policy_rate_hz: found 30; allowed: a divisor of 100"),
    ],
)
def test_conditions_are_checked(config, refused, keys, message):
    second = {"name": "another", "task": "joint_reach", **keys}
    config["sim_to_real"]["conditions"].append(second)
    assert f"config: sim_to_real.conditions{message}" in refused(config)


def test_tasks_are_named_once(config, refused):
    config["tasks"] = ["block_stack", "block_stack"]
    assert "config: tasks: found ['block_stack', 'block_stack']; allowed: a list" in refused(config)


def test_a_scoreboard_reads_other_studies(config, refused):
    config["scoreboard"] = {"studies": ["paper", config["study"]]}
    assert "config: scoreboard.studies[1]: found" in refused(config)


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        ("decoupling", {"task": "joint_reach"}, "decoupling.task: found 'joint_reach'; allowed: a"),
        ("decoupling", {"evaluate_every": 301}, "at most decoupling.updates = 300"),
        (
            "decoupling",
            {"pairings": [{"name": "a", "kp": 16, "kd": 8, "lambda_rad2": 1.0}] * 2},
            "decoupling.pairings[1].name: found 'a' a second time",
        ),
    ],
)
def test_decoupling_is_checked(config, refused, section, keys, message):
    config[section] = keys
    assert message in refused(config)


LIFT = {"task": "lift_cube", "action_scales": [{"kp": 16, "kd": 24, "rad": [2.0, 1.0]}]}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"task": "block_stack"}, "[0].task: found 'block_stack'; allowed: a task with a reward"),
        ({"rate_hz": 100}, "[0].rate_hz: found 100; allowed: from 200, at which the contacts"),
        ({"policy_rate_hz": 30}, "[0].policy_rate_hz: found 30; allowed: a divisor of learning"),
        ({"evaluate_every": 2000}, "[0].evaluate_every: found 2000; allowed: at most learning"),
        (
            {"action_scales": [{"kp": 16, "kd": 24, "rad": [2.0]}]},
            "[0].action_scales[0].rad: found a list of 1; allowed: one for each of proximal, dist",
        ),
        ({"searched": [{"kp": 16, "kd": 24}]}, "[0].searched[0]: found Kp 16, Kd 24 a second time"),
        (
            {"action_scales": []},
            "[0]: found no cell; allowed: cells under action_scales or searched",
        ),
    ],
)
def test_what_is_learned_in_simulation_alone_is_checked(config, refused, keys, message):
    config["learning"] = {"tasks": [{**LIFT, **keys}]}
    assert f"config: learning.tasks{message}" in refused(config)


def test_a_task_is_learned_once(config, refused):
    config["learning"] = {"tasks": [LIFT, LIFT]}
    assert "learning.tasks[1].task: found 'lift_cube' a second time" in refused(config)


@pytest.mark.parametrize("task", ["lift_cube", "pose_hold"])
def test_a_search_of_gains_has_a_twin_for_what_joints_alone_show(config, refused, task):
    twin = {"recordings": ["examples/two_joint_arm/train"], "model": "config/config.yaml"}
    entry = {"task": task, "kp": [16, 512], "kd": [4, 32], **twin}
    config["learning"] = {"gain_searches": [entry]}
    message = f"learning.gain_searches[0].recordings: found recordings for {task}, which has "
    assert message in refused(config)


def test_what_a_robots_joints_alone_cannot_do_is_not_deployed(config, refused):
    config["sim_to_real"]["conditions"] = [{"name": "lift", "task": "lift_cube"}]
    found = refused(config)
    assert "sim_to_real.conditions[0].task: found 'lift_cube', a task of fr3_hand" in found
    config["robot"] = {"name": "fr3_hand"}
    assert "which a robot's joints alone cannot do; allowed: a task without objects" in refused(
        config
    )


def test_a_landscape_needs_trials(config, refused):
    config["landscape"] = {"seeds": 5}
    config["sim_to_real"]["conditions"] = []
    assert "landscape: found this section, and no condition whose action" in refused(config)


def test_cameras_are_of_the_task_and_of_a_policy_that_sees(config, refused):
    config["observation"] = {"cameras": ["global", "rist"]}
    assert (
        "config: observation.cameras[1]: found 'rist' (did you mean wrist?); allowed: overview, "
        "global, wrist, cameras of block_stack"
    ) in refused(config)
    config["observation"] = {"cameras": ["wrist"]}
    load_extensions(["examples/extensions/nearest_neighbour.py"])
    config["training"] = {"policy": "nearest_neighbour"}
    message = "observation.cameras: found ['wrist']; allowed: none, as nearest_neighbour sees no"
    assert message in refused(config)


def test_pictures_are_shifted_only_where_there_are_some(config, refused):
    config["training"] = {"picture_shift_px": 4}
    message = "training.picture_shift_px: found 4; allowed: 0, as observation.cameras are none"
    assert message in refused(config)


PICKY = """
from t2l.policies.chunk_regression import ChunkRegression


class Picky(ChunkRegression):
    name = "picky_{part}"
    needs = ("{part}",)
"""


@pytest.mark.parametrize(
    ("part", "cameras", "said"),
    [
        ("environment", [], None),
        ("environment", ["global"], "pictures of observation.cameras are in its place"),
        ("pictures", ["global"], None),
        ("pictures", [], "block_stack does not show it"),
        # one that no data have
        ("touch", [], "block_stack does not show it"),
    ],
)
def test_a_policy_that_needs_what_the_data_lack_is_named(
    config, refused, no_extensions, tmp_path, part, cameras, said
):
    path = tmp_path / "picky.py"
    path.write_text(PICKY.format(part=part))
    config["extensions"] = [str(path)]
    config["observation"] = {"cameras": cameras}
    config["training"] = {"policy": f"picky_{part}"}
    if said is None:
        assert read_study(config, ROOT / "config").sections["training"]["policy"] == f"picky_{part}"
    else:
        message = f"training.policy: found 'picky_{part}', which needs to see the {part}; {said}"
        assert message in refused(config)


def test_pictures_that_no_memory_holds_are_refused(config, refused):
    config["observation"] = {"cameras": ["wrist", "global"], "size_px": 512}
    assert "observation.cameras, 3 × observation.size_px²: found 80 × 8" in refused(config)
    # a variant too
    config["variants"] = {"images": {"observation": config.pop("observation")}}
    assert "config: variants.images.demonstrations.count, horizon_s" in refused(config)
