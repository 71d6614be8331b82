import pytest


def test_joints_that_are_too_many_together_are_named(config, refused):
    config["attenuation"] = {"replicates": 100_000, "inertias_kg_m2": [0.1, 0.2, 0.3]}
    config["grid"] = {"kp": list(range(1, 11)), "kd": list(range(1, 11)), "overdamped_from_kd": 5}
    config["grid"]["compliant_up_to_kp"] = 5
    keys = "grid.kp, grid.kd, attenuation.replicates, attenuation.inertias_kg_m2"
    assert f"{keys}: found 100 × 100000 × 4; allowed: a product of at most" in refused(config)


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        (
            "reinforcement_learning",
            {"environments": 16_000, "horizon_s": 60},
            "reinforcement_learning.environments, reinforcement_learning.horizon_s: found "
            "16000 × 60; allowed: a product of at most 200000",
        ),
        ("training", {"history": 1000, "batch_size": 100_000}, "found 100000 × 1010"),
        ("training", {"history": 1000, "hidden": [4096]}, "found 4096 × 1010"),
        (
            "recording_grid",
            {"kp": list(range(1, 101)), "kd": list(range(1, 101))},
            "found 10000 × 100 × 1; allowed: a product of at most 20000",
        ),
    ],
)
def test_sizes_that_are_too_large_together_are_named(config, refused, section, keys, message):
    config[section].update(keys)
    config["sim_to_real"] = {
        "cells": "all",
        "conditions": [{"name": f"c{i}", "task": "joint_reach"} for i in range(100)],
    }
    assert message in refused(config)
