import copy

import pytest
import yaml

from t2l.config import read_study
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from tests.conftest import ROOT, configuration


@pytest.mark.parametrize("name", ["config", "studies/smoke", "studies/paper"])
def test_the_shipped_configurations_are_sound(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    study = read_study(configuration(name), ROOT / "config")
    assert study.variants["nominal"]["decimation"] == 10
    six = [
        *("block_stack", "mug_hanging", "dishwasher"),
        *("dishrack_loading", "dishrack_unloading", "bimanual_handover"),
    ]
    assert study.sections["tasks"] == (six if name == "studies/paper" else ["block_stack"])
    assert set(study.tasks) >= {"block_stack", *(entry.task for entry in study.conditions)}
    corners = (Cell(16, 2), Cell(512, 2), Cell(16, 24), Cell(512, 24))
    two = (Cell(32, 2), Cell(32, 32))
    assert study.fidelity_cells == (two if name == "studies/smoke" else corners)


def test_the_transfer_grid_is_run_whole(monkeypatch):
    monkeypatch.chdir(ROOT)
    study = read_study(configuration("studies/transfer_grid"), ROOT / "config")
    assert len(study.transfer_cells) == 25


def test_the_full_study_has_the_studys_grids():
    config = configuration("studies/paper")
    assert config["grid"]["kp"] == [32, 64, 128, 256, 512, 1024, 2048]
    assert config["grid"]["kd"] == [1, 2, 4, 8, 16, 32, 64, 128]
    assert config["recording_grid"]["kp"] == [16, 32, 64, 128, 160, 256, 512]
    assert config["recording_grid"]["kd"] == [1, 2, 4, 8, 12, 16, 24]
    assert config["demonstrations"]["count"] == config["rollouts"]["count"] == 100


def test_whole_numbers_become_integers_and_gains_stay_as_they_are(config):
    config["seed"], config["grid"]["kd"] = 1.0, [2, 8.0, 32, 128]
    sections = read_study(config, ROOT / "config").sections
    assert repr(sections["seed"]) == "1"
    assert repr(sections["grid"]["kd"]) == "[2, 8.0, 32, 128]"


def test_small_gains_have_names_that_lead_back(config):
    config["grid"]["kp"] = [1.0e-5, 32]
    config["grid"]["compliant_up_to_kp"] = 1
    cells = read_study(config, ROOT / "config").grid.cells
    assert cells[0].name == "kp0.00001_kd2"
    assert [Cell.from_name(cell.name) for cell in cells] == cells


def test_all_misspelt_and_missing_keys_are_told_at_once(config, refused):
    config["demonstratons"] = config.pop("demonstrations")
    config["sim_to_real"]["conditions"][0].pop("task")
    config["diagnosis"]["recording"] = config["diagnosis"].pop("recordings")
    config["seed"] = 1.5
    config[1] = 2
    del config["study"]
    lines = refused(config).splitlines()
    assert len(lines) == 7
    for beginning in (
        "config: demonstratons: found an unknown key (did you mean demonstrations?); allowed: ",
        "config: study: found nothing; allowed: name of the folder in `results/`",
        "config: sim_to_real.conditions[0].task: found nothing; allowed: name of a file in ",
        "config: diagnosis.recording: found an unknown key (did you mean recordings?); allowed: ",
        "config: diagnosis.recordings: found nothing; allowed: recordings, or folders of them",
        "config: seed: found 1.5; allowed: an integer",
        "config: 1: found an unknown key; allowed: study, seed, ",
    ):
        assert any(line.startswith(beginning) for line in lines), beginning


def test_problems_between_keys_are_told_at_once(config, refused):
    config["tasks"] = ["block_stck"]
    config["fidelity"]["replays"] = 101
    config["tuning"]["storage"] = "jornal"
    config["diagnosis"]["recordings"] = ["x"]
    assert len(refused(config).splitlines()) == 4


def test_thousands_of_problems_are_cut_short(config, refused):
    config.update({f"key{i}": 0 for i in range(1000)})
    assert refused(config).endswith("and 950 more such lines")


def test_a_task_file_that_is_no_yaml_is_named(config, tmp_path, monkeypatch):
    (tmp_path / "tasks").mkdir()
    config["sim_to_real"]["conditions"] = []
    path = tmp_path / "tasks/block_stack.yaml"
    for content, message in (
        (b"kind: [block_stack", "what is not YAML"),
        (b"- kind\n- block_stack\n", "found ['kind', 'block_stack']; allowed: the key kind"),
        (b"", "found nothing; allowed: the key kind"),
        (bytes(range(256)), "what is not text in UTF-8"),
        (
            b"kind: [block_stack]",
            "(did you mean block_stack?); allowed: block_stack",
        ),
        (b"kind: block_stack\nkind: block_stack", "the key 'kind' twice"),
        (b"a: &a [*a]", "*a within itself"),
    ):
        path.write_bytes(content)
        with pytest.raises(ConfigurationError) as error:
            read_study(config, tmp_path)
        assert str(error.value).startswith(str(path))
        assert message in str(error.value)


def test_a_bad_task_file_is_named(config, tmp_path, block_stack):
    (tmp_path / "tasks").mkdir()
    config["sim_to_real"]["conditions"] = []
    for change, message in (
        (
            {"block_size_m": 0.2},
            r"block_stack.yaml: block_size_m: found 0.2; allowed: up to 0.07",
        ),
        ({"workspace_x_m": [0.6, 0.4]}, "workspace_x_m: found .*low below high"),
        ({"kind": "block_stak"}, r"found 'block_stak' \(did you mean block_stack\?\)"),
        ({"gravity": 1}, "gravity: found an unknown key"),
        ({"gravity_compensation": 1}, "gravity_compensation: found 1; allowed: true or false"),
        ({"horizon_s": float("nan")}, "horizon_s: found nan; allowed: a finite number"),
        ({1: 2}, "block_stack.yaml: 1: found an unknown key"),
    ):
        task = copy.deepcopy(block_stack) | change
        (tmp_path / "tasks/block_stack.yaml").write_text(yaml.safe_dump(task))
        with pytest.raises(ConfigurationError, match=message):
            read_study(config, tmp_path)
