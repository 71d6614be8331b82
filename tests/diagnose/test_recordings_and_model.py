import dataclasses
import shutil

import numpy as np
import pytest

from t2l.diagnose.recordings_and_model import read_recordings_and_model
from t2l.errors import ConfigurationError, RecordingError
from t2l.identify.model import Model, write_model
from t2l.recordings import write_recording
from tests.diagnose.made import pendulum, recording, swing, two_pendulums
from tests.effects.test_registry import RUBBER


@pytest.fixture
def robot(tmp_path):
    return pendulum(tmp_path, 'range="-1.5 1.5" limited="true"')


def write(folder, name, robot, **changes):
    made = recording(robot, swing(), name, duration_s=0.5)
    # no two have the same noise
    noise = 1e-4 * np.random.default_rng(sum(name.encode())).normal(size=made.q.shape)
    made = dataclasses.replace(made, **{"q": made.q + noise, **changes})
    return write_recording(made, folder / "logs" / name)


@pytest.fixture
def logs(tmp_path, robot):
    for name in ("a", "b", "c"):
        write(tmp_path, name, robot)
    return tmp_path / "logs"


def message(error, *arguments, **keywords):
    with pytest.raises(error) as caught:
        read_recordings_and_model(*arguments, **keywords)
    return str(caught.value)


def test_a_folder_is_read_with_the_robot_of_its_recordings(logs, robot):
    model, recordings, held = read_recordings_and_model([logs])
    assert model.robot == robot
    assert model.effects == {}
    assert [r.name for r in recordings] == ["a", "b", "c"]
    assert held == []


def test_a_model_and_effects_of_ones_own_come_along(logs, robot, tmp_path):
    rubber = tmp_path / "rubber.py"
    rubber.write_text(RUBBER)
    write_model(
        Model(robot, {"command_delay": {"delay": 0.01}}), tmp_path / "models" / "model.yaml"
    )
    model, recordings, held = read_recordings_and_model(
        [logs / "a.csv", logs / "b"],
        [logs / "c.yaml"],
        tmp_path / "models" / "model.yaml",
        [rubber],
    )
    assert model.effects == {"command_delay": {"delay": 0.01}}
    assert "rubber" in model.known_effects()
    assert [r.name for r in recordings] == ["a", "b"]
    assert [r.name for r in held] == ["c"]


def test_another_robot_is_named(logs, robot, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    write(tmp_path, "d", pendulum(other, 'range="-1.5 1.5" limited="true" damping="0.03"'))
    text = message(RecordingError, [logs])
    assert "d.csv" in text
    assert "robot" in text
    assert robot in text


def test_a_copy_of_the_robot_is_the_same_robot(logs, robot, tmp_path):
    """As a folder of recordings that somebody else sent brings it."""
    copy = shutil.copy(robot, tmp_path / "copy.xml")
    write(tmp_path / "held", "d", str(copy))
    model, recordings, held = read_recordings_and_model([logs], [tmp_path / "held" / "logs"])
    assert held[0].robot != recordings[0].robot == model.robot


def test_other_joints_are_named(logs, tmp_path, robot):
    both = two_pendulums(tmp_path)
    made = recording(both, lambda t: np.zeros((len(t), 2)), "d", duration_s=0.5)
    write_recording(made, logs / "d")
    text = message(RecordingError, [logs])
    assert "d.csv" in text
    assert "left, right" in text
    assert "hinge" in text


def test_a_joint_that_the_robot_does_not_have_is_named(tmp_path, robot):
    write(tmp_path, "a", robot, joints=("knee",))
    text = message(RecordingError, [tmp_path / "logs"])
    assert "a.csv" in text
    assert "knee" in text
    assert "hinge" in text


@pytest.mark.parametrize("held", ["c", "c.csv", "c.yaml", "../logs/c.csv"])
def test_a_recording_is_either_fitted_or_held_out(logs, held):
    text = message(RecordingError, [logs], [logs / held])
    assert "c.csv" in text
    assert "--holdout" in text


def test_a_copy_under_another_name_is_not_held_out(logs, tmp_path, caplog):
    (tmp_path / "held").mkdir()
    for ending in ("csv", "yaml"):
        shutil.copy(logs / f"b.{ending}", tmp_path / f"held/other.{ending}")
    text = message(RecordingError, [logs], [tmp_path / "held"])
    assert "other.csv: --holdout: found the measurements of" in text
    assert "b.csv" in text
    read_recordings_and_model([logs, tmp_path / "held"])
    assert "other.csv: holds the measurements of" in caplog.text


def test_a_held_out_recording_is_the_same_by_any_path(logs, monkeypatch):
    """Given relative and absolute."""
    monkeypatch.chdir(logs)
    read_recordings_and_model(["a", "b"], [logs / "c.csv"])
    text = message(RecordingError, ["a", "b", "c"], [logs / "c.csv"])
    assert "--holdout" in text


def test_degrees_are_told(tmp_path, robot):
    degrees = np.rad2deg(recording(robot, swing(), duration_s=0.5).q_des)
    write(tmp_path, "a", robot, q_des=degrees, q=degrees)
    text = message(RecordingError, [tmp_path / "logs"])
    assert "a.csv" in text
    assert "q_des.hinge" in text
    assert "degrees" in text


def test_held_out_recordings_are_checked_too(logs, tmp_path, robot):
    far = np.full((51, 1), 2.0)
    (tmp_path / "held").mkdir()
    write(tmp_path / "held", "far", robot, q_des=far, q=far)
    text = message(RecordingError, [logs], [tmp_path / "held" / "logs"])
    assert "far.csv" in text
    assert "-1.5 to 1.5" in text


def test_a_model_of_other_joints_is_named(logs, robot, tmp_path):
    path = tmp_path / "model.yaml"
    write_model(Model(robot, {"torque_offset": {"torque": {"knee": 0.1}}}), path)
    text = message(ConfigurationError, [logs], model_path=path)
    assert str(path) in text
    assert "torque_offset.torque" in text
    assert "knee" in text


def test_a_model_whose_robot_is_gone_is_named(logs, tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text("robot: gone.xml\n")
    text = message(ConfigurationError, [logs], model_path=path)
    assert "gone.xml" in text
    assert str(path) in text


def test_a_missing_recording_is_named(tmp_path):
    assert "nowhere" in message(RecordingError, [tmp_path / "nowhere.csv"])


def test_a_missing_effect_file_is_named(logs, tmp_path):
    text = message(ConfigurationError, [logs], effect_files=[tmp_path / "mine.py"])
    assert f"{tmp_path}/mine.py: no such file" in text
