import pytest

from t2l.config import read_study
from tests.conftest import ROOT


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        ("grid", {"kp": [-1, 2]}, "grid.kp[0]: found -1; allowed: a number above 0"),
        ("grid", {"kp": [1e-7, 2]}, "grid.kp[0]: found 1e-07; allowed: a number from 1e-06 up"),
        ("grid", {"kp": [1, 10**400]}, "grid.kp[1]: found 1000"),
        ("grid", {"kp": [64, 32]}, "grid.kp: found [64, 32]; allowed: numbers in ascending order"),
        ("grid", {"kd": [2, float("nan")]}, "grid.kd[1]: found nan; allowed: a finite number"),
        ("grid", {"kd": [2, float("inf")]}, "grid.kd[1]: found inf; allowed: a finite number"),
        ("grid", {"kd": [2, 2]}, "without repetitions"),
        ("grid", {"kd": list(range(1, 102))}, "allowed: a list with at most 100 elements"),
        ("demonstrations", {"count": 10**18}, "an integer up to 1e+12"),
        ("demonstrations", {"count": 10**7}, "found 10000000; allowed: a number up to 5000"),
        ("retargeting", {"policy_rate_hz": 2.0**-20}, "allowed: a number from 1 up"),
        (
            "retargeting",
            {"hold": "median"},
            "found 'median' (did you mean mean?); allowed: mean",
        ),
        ("training", {"epochs": "many"}, "training.epochs: found 'many'; allowed: an integer"),
        ("training", {"epochs": 10**9}, "training.epochs: found 1000000000; allowed: a number"),
        ("training", {"epochs": True}, "training.epochs: found True; allowed: an integer"),
        ("training", {"history": 10**6}, "training.history: found 1000000; allowed: a number"),
        ("training", {"hidden": [256, 10**6]}, "training.hidden[1]: found 1000000; allowed:"),
        ("training", {"hidden": [8] * 100}, "training.hidden: found"),
        ("training", {"batch_size": 10**10}, "training.batch_size: found 10000000000"),
        ("rollouts", {"count": 10**8}, "rollouts.count: found 100000000; allowed: a number"),
        ("identification", {"population": 10**8}, "identification.population: found"),
        ("identification", {"iterations": 10**9}, "identification.iterations: found"),
        ("reinforcement_learning", {"environments": 10**6}, ".environments: found 1000000;"),
        ("reinforcement_learning", {"seed": 2**32}, ".seed: found 4294967296; allowed:"),
        ("tuning", {"workers": 10**6}, "tuning.workers: found 1000000; allowed: a number up to"),
        ("tuning", {"trials": 10**9}, "tuning.trials: found 1000000000; allowed: a number up to"),
        ("tuning", {"action_scale": [5, 0.1]}, "tuning.action_scale: found [5, 0.1]; allowed: two"),
        ("tuning", {"reward_weights": {"positon": [1, 2]}}, "(did you mean position?); allowed:"),
        ("tuning", {"reward_weights": {"position": [2, 1]}}, "two ascending bounds"),
        ("sim_to_real", {"seeds": 10**6}, "sim_to_real.seeds: found 1000000;"),
        ("deployment", {"rollouts": 10**6}, "deployment.rollouts: found 1000000; allowed:"),
        ("deployment", {"workspace_lower_m": None}, "workspace_lower_m: found nothing; allowed:"),
        ("diagnosis", {"recordings": []}, "diagnosis.recordings: found []; allowed: a list with"),
        ("diagnosis", {1: 2}, "diagnosis.1: found an unknown key; allowed: recordings, holdout"),
        ("diagnosis", {"a\nb": 2}, "config: diagnosis.a\\nb: found an unknown key"),
    ],
)
def test_what_a_key_may_not_hold_is_named(config, refused, section, keys, message):
    config[section].update(keys)
    lines = refused(config).splitlines()
    assert any(message in line for line in lines), lines
    assert all(line.startswith("config: ") and len(line) < 600 for line in lines)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("study", "x\n", "config: study: found 'x\\n'; allowed: letters, digits, _ and -"),
        ("study", "x" * 5000, "config: study: found 'xxx"),
        ("study", "../x", "config: study: found '../x'; allowed: letters"),
        ("seed", 10**400, "config: seed: found 1000"),
        ("seed", 10**18, "config: seed: found 1000000000000000000; allowed: an integer up to"),
        ("seed", 1.5, "config: seed: found 1.5; allowed: an integer"),
        ("diagnosis", None, "config: diagnosis: found nothing; allowed: a value, or no such key"),
        ("training", [], "config: training: found []; allowed: keys with values"),
        ("\ud800", 1, "config: found '\\ud800'; allowed: text in Unicode"),
        ("study", "\ud800", "config: study: found '\\ud800'"),
        ("y" * 5000, 1, "found an unknown key"),
    ],
)
def test_what_a_configuration_may_not_hold_is_named(config, refused, key, value, message):
    config[key] = value
    lines = refused(config).splitlines()
    assert any(message in line for line in lines), lines
    assert all(len(line) < 600 for line in lines)


def test_names_of_conditions_are_folders(config, refused):
    config["sim_to_real"]["conditions"][0]["name"] = "a/b"
    assert "sim_to_real.conditions[0].name: found 'a/b'; allowed: letters" in refused(config)


@pytest.mark.parametrize("section", ["robot", "diagnosis"])
def test_optional_keys_are_left_out_and_not_left_empty(config, refused, section):
    key = {"robot": "address", "diagnosis": "model"}[section]
    config[section][key] = None
    assert f"config: {section}.{key}: found nothing; allowed: a value, or no" in refused(config)


def test_what_is_absent_has_its_default():
    sections = read_study({"study": "x", "grid": {"kp": [32, 256]}}, ROOT / "config").sections
    assert "diagnosis" not in sections
    assert sections["robot"] == {"name": "fr3", "backend": "virtual"}
    assert sections["grid"]["kp"] == [32, 256]
    assert sections["grid"]["kd"] == [2, 8, 32, 128]
    assert sections["sim_to_real"]["conditions"][0] == {
        "name": "joint_reach",
        "task": "joint_reach",
        "actions": {"kind": "joint_delta"},
        "policy_rate_hz": 50.0,
        "randomisation": 0.0,
        "action_scales": [],
    }
