"""Joints that are read later than their row's time says."""

import dataclasses

import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import read_recording, write_recording
from tests.diagnose.made import predict, recording, swing, two_pendulums
from tests.recordings.made import written

NOISE_RAD = 2e-4
SKEW_S = np.array([0.0, 0.012])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return two_pendulums(tmp_path_factory.mktemp("robot"))


def both(t):
    return np.stack([swing(0.5, 0.8)(t), swing(0.4, 1.1)(t)], axis=1)


def from_rest(t):
    """Hanging still for 0.1 s."""
    return np.minimum(np.maximum(t - 0.1, 0) / 0.3, 1.0)[:, None] ** 2 * both(t)


def read_in_turn(robot, skew_s=SKEW_S, row_rate_hz=100.0, command=from_rest):
    """A recording at whose rows the joints were read in turn: of one at 1 kHz, rows in between."""
    fine = recording(robot, command, duration_s=2.1, row_rate_hz=1000.0, command_rate_hz=100.0)
    held = (np.arange(len(fine.time)) // round(1000 / row_rate_hz)) * round(1000 / row_rate_hz)
    fine = dataclasses.replace(fine, q_des=fine.q_des[held])
    q = predict(fine).reshape(fine.q.shape)
    rows = np.arange(50, 2050, round(1000 / row_rate_hz))
    late = rows[:, None] + np.round(1e3 * skew_s).astype(int)
    noise = NOISE_RAD * np.random.default_rng(0).normal(size=late.shape)
    return dataclasses.replace(
        fine, time=fine.time[rows], q_des=fine.q_des[rows], q=q[late, [0, 1]] + noise, skew_s=skew_s
    )


def rms(made):
    error = predict(made) - Predictor(made.robot, [made]).samples.q
    return np.sqrt(np.mean(error**2))


@pytest.mark.parametrize("skew_s", [SKEW_S, -SKEW_S, np.array([0.007, 0.003])])
def test_a_known_skew_leaves_the_noise(robot, skew_s):
    made = read_in_turn(robot, skew_s)
    assert rms(made) == pytest.approx(NOISE_RAD, rel=0.15)
    assert rms(dataclasses.replace(made, skew_s=None)) > 5 * NOISE_RAD


def test_a_recording_that_begins_in_motion_begins_where_its_first_row_is(robot):
    made = read_in_turn(robot, command=both)
    layout, u = Model(robot).vector(made.joints)
    predictor = Predictor(robot, [made], threads=1, in_motion=True)
    first = predictor.predict([Request(layout, u[None])])[0][0][:2] - predictor.samples.q[:2]
    speed = np.diff(made.q[:2, 1])[0] / 0.01
    assert abs(speed * SKEW_S[1]) > 0.01  # by which it would be off
    assert np.abs(first).max() < 0.0025


def test_samples_lie_at_their_own_time(robot):
    made = read_in_turn(robot)
    samples = Predictor(robot, [made], threads=1).samples
    for j in (0, 1):
        own = samples.time[samples.joint == j]
        assert own == pytest.approx(made.time - made.time[0] + SKEW_S[j])


def test_what_was_read_before_the_first_row_is_left_out(robot):
    made = read_in_turn(robot, -SKEW_S)
    samples = Predictor(robot, [made], threads=1).samples
    assert np.bincount(samples.joint).tolist() == [len(made.time), len(made.time) - 2]


def test_a_skew_is_written_and_read(tmp_path, robot):
    made = read_in_turn(robot)
    table = write_recording(made, tmp_path / "turn")
    assert np.array_equal(read_recording(table).skew_s, SKEW_S)


@pytest.mark.parametrize("value", [{"b": 0.012}, [0, 0.012], {"a": 0, "b": 0.012}])
def test_a_skew_is_by_joint_or_in_their_order(tmp_path, value):
    files = written(tmp_path)
    files.spoil_key("skew_s", value)
    assert np.array_equal(read_recording(files.table).skew_s, SKEW_S)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({"c": 0.01}, "key skew_s: found 'c'; allowed: joints of this recording: a, b"),
        ([0.01], r"key skew_s: found \[0.01\]; allowed: seconds by joint, or one number for each"),
        (0.01, "key skew_s: found 0.01; allowed: seconds by joint"),
        ({"a": 12}, "key skew_s: found {'a': 12}; allowed: .* up to 1 s"),
        ({"a": "late"}, "key skew_s: found {'a': 'late'}"),
    ],
)
def test_a_wrong_skew_is_named(tmp_path, value, message):
    files = written(tmp_path)
    files.spoil_key("skew_s", value)
    with pytest.raises(RecordingError, match=message):
        read_recording(files.table)
