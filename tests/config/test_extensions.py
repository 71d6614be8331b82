"""Files of one's own that a configuration names."""

import pytest

from t2l.config import read_study
from t2l.robots import ROBOTS, make_robot
from tests.conftest import ROOT
from tests.made_extension import write_robot


def test_what_extensions_define_is_known_from_then_on(config, tmp_path):
    path = write_robot(tmp_path / "mine.py", "configured_pendulum")
    study = read_study({**config, "extensions": [str(path)]}, ROOT / "config")
    assert study.sections["extensions"] == [str(path)]
    assert "configured_pendulum" in ROBOTS.names()
    assert make_robot("configured_pendulum").joints == ("hinge",)


def test_a_policy_of_ones_own_trains_the_nominal(config, no_extensions):
    """And says what else the section may hold."""
    config["extensions"] = ["examples/extensions/nearest_neighbour.py"]
    config["training"] = {"policy": "nearest_neighbour", "every": 2}
    training = read_study(config, ROOT / "config").sections["training"]
    assert training == {"policy": "nearest_neighbour", "validation_fraction": 0.1, "every": 2}


def test_without_extensions_there_is_no_such_section(config):
    assert "extensions" not in read_study(config, ROOT / "config").sections


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (["nowhere.py"], "extensions[0]: found 'nowhere.py', which is not there; allowed: a"),
        (["config/tasks"], "extensions[0]: found 'config/tasks', which is not there; allowed:"),
        ([], "extensions: found []; allowed: a list with at least 1 element"),
        ("mine.py", "extensions: found 'mine.py'; allowed: a list"),
        ([3], "extensions[0]: found 3; allowed: text"),
        (None, "extensions: found nothing; allowed: a value, or no such key"),
    ],
)  # fmt: skip
def test_what_the_key_may_not_hold_is_named(config, refused, value, message):
    assert f"config: {message}" in refused({**config, "extensions": value})


def test_a_file_that_cannot_be_imported_is_named(config, refused, tmp_path):
    (tmp_path / "broken.py").write_text("import nothing_of_that_name\n")
    said = refused({**config, "extensions": [str(tmp_path)]})
    assert f"config: extensions: extension file {tmp_path / 'broken.py'}: cannot be imp" in said
    assert "nothing_of_that_name" in said
    assert "\n" not in said
