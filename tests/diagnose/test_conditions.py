import dataclasses

import numpy as np
import pytest

from t2l.diagnose import conditions
from t2l.diagnose.conditions import CONDITIONS, Series, correlation, features
from t2l.effects.registry import builtin
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from tests.diagnose.made import WEIGHT, recording, swing, two_pendulums


def _predicted(recordings, model=None):
    model = model or Model(recordings[0].robot)
    predictor = Predictor(model.robot, recordings, threads=1)
    layout, u = model.vector(predictor.joints)
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    return predictor, q[0], dq[0]


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Two joints under different gains, sampled at every other row."""
    robot = two_pendulums(tmp_path_factory.mktemp("two"))
    both = recording(
        robot,
        lambda t: np.stack([swing()(t), swing(0.3, 1.1, -0.4)(t)], axis=1),
        duration_s=2.0,
        gravity_compensation=True,
    )
    both = dataclasses.replace(both, kp=np.array([20.0, 5.0]), kd=np.array([0.8, 0.4]))
    both.q[1::2] = np.nan
    return both, _predicted([both])


def test_every_effect_follows_a_condition_that_exists():
    for effect in builtin().values():
        assert effect.follows in CONDITIONS, effect.name


def test_features_are_what_they_say(two):
    both, (predictor, q, dq) = two
    found = features(predictor, q, dq)
    assert set(found) == set(CONDITIONS) == set(conditions.UNITS)
    samples = predictor.samples
    assert all(values.shape == (len(samples),) for values in found.values())
    np.testing.assert_allclose(found["gravity"], WEIGHT * np.sin(samples.q), atol=1e-9)
    command = both.q_des[samples.row, samples.joint]
    torque = both.kp[samples.joint] * (command - q) - both.kd[samples.joint] * dq
    np.testing.assert_allclose(found["torque"], torque + found["gravity"], atol=1e-9)
    np.testing.assert_allclose(found["velocity squared"], dq * np.abs(dq))
    np.testing.assert_array_equal(found["load"], found["direction"] * np.abs(found["torque"]))
    assert set(np.unique(found["direction"])) <= {-1.0, 0.0, 1.0}
    # the command moves once a row, so that over one period it is the difference of two rows
    before = both.q_des[np.maximum(samples.row - 1, 0), samples.joint]
    np.testing.assert_allclose(found["command velocity"], 100 * (command - before), atol=1e-9)


def test_gravity_compensation_is_part_of_the_torque_only_where_there_is_one(two):
    both, (predictor, q, dq) = two
    without = dataclasses.replace(both, gravity_compensation=False)
    other = Predictor(without.robot, [without], threads=1)
    difference = features(predictor, q, dq)["torque"] - features(other, q, dq)["torque"]
    np.testing.assert_allclose(difference, WEIGHT * np.sin(predictor.samples.q), atol=1e-9)


def test_rates_stay_within_a_joint_of_a_recording(tmp_path):
    robot = two_pendulums(tmp_path)
    recordings = [
        recording(robot, lambda t: np.stack([3 * t, -5 * t], axis=1), name, duration_s=0.5)
        for name in ("first", "second")
    ]
    samples = Predictor(robot, recordings, threads=1).samples
    slope = np.array([3.0, -5.0])[samples.joint]
    values = slope * samples.time + 100.0 * samples.recording + 7.0 * samples.joint
    np.testing.assert_allclose(Series(samples).rate(values), slope, atol=1e-9)


def test_correlation_is_per_joint():
    rng = np.random.default_rng(0)
    joint = np.tile([0, 1], 200)
    feature = rng.normal(size=400)
    residual = np.where(joint == 0, -2.0 * feature, rng.normal(size=400))
    found = correlation(residual, feature, joint)
    assert found[0] == pytest.approx(-1.0)
    assert abs(found[1]) < 0.2


def test_what_never_varies_is_compared_with_the_mean():
    joint = np.zeros(100, int)
    ones = np.ones(100)
    np.testing.assert_allclose(correlation(-0.3 * ones, ones, joint), -1.0)
    assert abs(correlation(np.tile([1.0, -1.0], 50), ones, joint)[0]) < 1e-12
    assert correlation(0 * ones, np.arange(100.0), joint)[0] == 0.0
