import pytest

from t2l.config import read_study
from tests.conftest import ROOT


def study_of(config):
    return read_study(config, ROOT / "config")


def test_a_variant_is_the_nominal_but_for_what_it_names(config):
    config["variants"] = {
        "chunk_1": {"training": {"chunk": 1}, "rollouts": {"executed_actions": 1}},
        "slow": {"retargeting": {"policy_rate_hz": 10}},
    }
    variants = study_of(config).variants
    assert list(variants) == ["nominal", "chunk_1", "slow"]
    nominal, chunk_1, slow = variants.values()
    assert (nominal["decimation"], slow["decimation"]) == (10, 50)
    assert chunk_1["training"] == nominal["training"] | {"chunk": 1}
    assert chunk_1["rollouts"] == nominal["rollouts"] | {"executed_actions": 1}
    assert slow["training"] == nominal["training"]


def test_a_variant_may_have_an_operator(config):
    config["variants"] = {"operator": {"operator": {"reaction_s": 0.3}}}
    variants = study_of(config).variants
    assert variants["nominal"]["operator"] is None
    assert variants["operator"]["operator"]["reaction_s"] == 0.3
    assert variants["operator"]["operator"]["practice"] == 16


def test_a_variant_with_another_policy_has_that_policys_keys(config, tmp_path):
    config["extensions"] = ["examples/extensions/nearest_neighbour.py"]
    study_of(config)
    config["variants"] = {"nearest": {"training": {"policy": "nearest_neighbour", "every": 2}}}
    training = study_of(config).variants["nearest"]["training"]
    assert training == {"policy": "nearest_neighbour", "validation_fraction": 0.1, "every": 2}


@pytest.mark.parametrize(
    ("variant", "message"),
    [
        (
            {"training": {"epoch": 3}},
            "config: variants.a.training.epoch: found an unknown key (did",
        ),
        ({"training": {"epochs": 0}}, "config: variants.a.training.epochs: found 0; allowed: a"),
        (
            {"operator": {"crossover_rad_s": [9]}},
            "variants.a.operator.crossover_rad_s[0]: found 9; allowed: a number below",
        ),
        ({"task": {}}, "config: variants.a.task: found an unknown key"),
        ({"training": {"chunk": 1}}, "variants.a.rollouts.executed_actions: found 10; allowed: at"),
        ({"demonstrations": {"count": 7}}, "variants.a.demonstrations.count: found what all"),
        ({"demonstrations": {"used": 101}}, "variants.a.demonstrations.used: found 101; allowed: "),
        (
            {"demonstrations": {"used": {"kp31_kd2": 5}}},
            "variants.a.demonstrations.used.kp31_kd2: found a cell that is not in the grid (did",
        ),
        (
            {"demonstrations": {"used": {"kp32_kd2": 1}}},
            "variants.a.demonstrations.used.kp32_kd2: found 1; allowed: a number from 2 up",
        ),
    ],
)
def test_what_is_wrong_with_a_variant_is_named(config, refused, variant, message):
    config["variants"] = {"a": variant}
    assert message in refused(config)


def test_what_is_wrong_with_the_nominal_is_said_once(config, refused):
    config["variants"] = {"a": {"training": {"epochs": 3}}}
    config["rollouts"]["executed_actions"] = 11
    assert refused(config).count("executed_actions") == 1


@pytest.mark.parametrize("name", ["noise", "collection1"])
def test_a_name_that_is_a_folder_of_results_is_refused(name, config, refused):
    config["variants"] = {name: {"training": {"epochs": 3}}}
    assert f"config: variants.{name}: found a name that is taken" in refused(config)


def test_more_collections_are_more_jobs(config, refused):
    config |= {"collections": 100, "training_seeds": 100, "variants": {}}
    assert "collections" in refused(config)
