import copy

import pytest
import yaml
from snakemake.utils import update_config

from t2l.config import read_study
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from tests.conftest import ROOT


@pytest.fixture
def config():
    return yaml.safe_load((ROOT / "config/config.yaml").read_text())


@pytest.mark.parametrize("name", ["config", "smoke", "paper"])
def test_the_shipped_configurations_are_sound(name):
    config = yaml.safe_load((ROOT / f"config/{name}.yaml").read_text())
    study = read_study(config, ROOT / "config")
    assert study.decimation == 10
    assert set(study.tasks) == {"block_stack"}
    assert study.fidelity_cells == (Cell(16, 2), Cell(512, 2), Cell(16, 24), Cell(512, 24))


def test_a_configuration_inherits_what_it_leaves_out(config):
    deployment = copy.deepcopy(config["deployment"])
    update_config(config, yaml.safe_load((ROOT / "config/transfer_grid.yaml").read_text()))
    study = read_study(config, ROOT / "config")
    assert len(study.transfer_cells) == 25
    assert config["deployment"] == deployment


def test_the_full_study_has_the_studys_grids():
    config = yaml.safe_load((ROOT / "config/paper.yaml").read_text())
    assert config["grid"]["kp"] == [32, 64, 128, 256, 512, 1024, 2048]
    assert config["grid"]["kd"] == [1, 2, 4, 8, 16, 32, 64, 128]
    assert config["recording_grid"]["kp"] == [16, 32, 64, 128, 160, 256, 512]
    assert config["recording_grid"]["kd"] == [1, 2, 4, 8, 12, 16, 24]
    assert config["demonstrations"]["count"] == config["rollouts"]["count"] == 100


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        ("grid", {"kp": [-1, 2]}, r"grid.kp\[0\]: found -1; allowed: a number above 0"),
        ("grid", {"kp": [64, 32]}, "grid.kp: found .*ascending"),
        ("grid", {"kd": [2, float("nan")]}, r"grid.kd\[1\]: found nan; allowed: a finite number"),
        ("grid", {"kd": [2, 2]}, "without repetitions"),
        ("grid", {"compliant_up_to_kp": 1}, "put 0 of 16 cells"),
        ("demonstrations", {"max_attempts": 10}, "at least demonstrations.count = 100"),
        ("retargeting", {"policy_rate_hz": 60}, "a divisor of the simulation's 500 Hz"),
        ("retargeting", {"hold": "median"}, "found 'median'; allowed: mean, sample"),
        ("fidelity", {"replays": 101}, "at most demonstrations.count = 100"),
        ("training", {"epochs": "many"}, "training.epochs: found 'many'; allowed: an integer"),
        ("training", {"validation_fraction": 0.999}, "leaves demonstrations to train on"),
        ("rollouts", {"executed_actions": 11}, "at most training.chunk = 10"),
    ],
)
def test_what_cannot_run_is_named(config, section, keys, message):
    config[section].update(keys)
    with pytest.raises(ConfigurationError, match=message):
        read_study(config, ROOT / "config")


def test_all_misspelt_and_missing_keys_are_told_at_once(config):
    config["demonstratons"] = config.pop("demonstrations")
    config["rollouts"]["cuont"] = config["rollouts"].pop("count")
    with pytest.raises(ConfigurationError) as error:
        read_study(config, ROOT / "config")
    text = str(error.value)
    assert "demonstratons: no such key (did you mean demonstrations?)" in text
    assert "rollouts.cuont: no such key (did you mean count?)" in text
    assert "rollouts.count: missing" in text


def test_a_bad_task_file_is_named(config, tmp_path, block_stack):
    folder = tmp_path / "config"
    (folder / "tasks").mkdir(parents=True)
    (folder / "schema").symlink_to(ROOT / "config/schema")
    for change, message in (
        (
            {"block_size_m": 0.2},
            r"block_stack.yaml: block_size_m: found 0.2; allowed: .* up to 0.07",
        ),
        ({"workspace_x_m": [0.6, 0.4]}, "workspace_x_m: found .*low below high"),
        ({"kind": "block_stak"}, "kind: found 'block_stak'; allowed: block_stack"),
        ({"gravity": 1}, "gravity: no such key"),
    ):
        task = copy.deepcopy(block_stack) | change
        (folder / "tasks/block_stack.yaml").write_text(yaml.safe_dump(task))
        with pytest.raises(ConfigurationError, match=message):
            read_study(config, folder)
