import pytest

from t2l.config import read_study
from tests.conftest import ROOT

TRAIN = "examples/two_joint_arm/train"


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"recordings": ["x"]}, "diagnosis.recordings[0]: found 'x', which is not there; allowed:"),
        ({"recordings": ["src"]}, "diagnosis.recordings[0]: found 'src', which is not there"),
        ({"recordings": [TRAIN], "holdout": ["y"]}, "diagnosis.holdout[0]: found 'y', which"),
        ({"recordings": [TRAIN], "model": "y"}, "diagnosis.model: found 'y', which is not there"),
        (
            {"recordings": [TRAIN], "holdout": ["examples/two_joint_arm/holdout", TRAIN]},
            "diagnosis.holdout[1]: found 'examples/two_joint_arm/train/",
        ),
        (
            {"recordings": [TRAIN], "holdout": [f"{TRAIN}/../train/medium_steps"]},
            "diagnosis.holdout[0]: found 'examples/two_joint_arm/train/../train/medium_steps.csv', "
            "which is in diagnosis.recordings[0] too; allowed: recordings that are not fitted",
        ),
        ({"recordings": [TRAIN], "effects": ["y"]}, "diagnosis.effects[0]: found 'y', which"),
        ({"recordings": ["\ud800"]}, "diagnosis.recordings[0]: found '\\ud800'; allowed: text"),
        ({"recordings": ["x/" * 490]}, "diagnosis.recordings[0]: found 'x/x/"),
        ({"recordings": ["x" * 900]}, "diagnosis.recordings[0]: found 'xxxxx"),
        ({"recordings": ["a\0b"]}, "diagnosis.recordings[0]: found 'a\\x00b'; allowed: text"),
    ],
)
def test_files_of_a_diagnosis_that_are_missing_are_named(config, refused, keys, message):
    config["diagnosis"] = keys
    assert f"config: {message}" in refused(config)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            None,
            "attenuation.published_grids: found 'page.json', which is not there; allowed: a dow",
        ),
        ("{", "attenuation.published_grids: found page.json, with"),
        ('{"taskData": {"a": {"kps": 1}}}', "something else at taskData.a.kps; allowed: a list"),
    ],
)
def test_published_grids_that_cannot_be_read_are_named(
    config, refused, tmp_path, monkeypatch, text, message
):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        (tmp_path / "page.json").write_text(text)
    config["attenuation"] = {"published_grids": "page.json"}
    assert message in refused(config)


@pytest.mark.parametrize("ending", ["", ".csv", ".yaml"])
def test_a_recording_may_be_named_by_either_file_or_without_ending(config, ending):
    config["diagnosis"] = {"recordings": [f"{TRAIN}/medium_steps{ending}"]}
    assert read_study(config, ROOT / "config").sections["diagnosis"] == config["diagnosis"]
