"""Elastic elements of a hysteresis begin where they hold the joint."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.effects.law import HYSTERESIS, Curve, Law
from t2l.effects.yielding import stretched_at_start
from t2l.identify.model import Model
from tests.diagnose.made import WEIGHT, hold, pendulum, predict, recording

AWAY = 0.5  # rad, from where the pendulum hangs
NEEDED = WEIGHT * np.sin(AWAY)  # N·m, that holds it there


@st.composite
def elements(draw):
    """Radii, rad, and weights, N·m, of some elements."""
    steps = draw(st.lists(st.floats(1e-3, 0.5), min_size=1, max_size=6))
    weights = draw(st.lists(st.floats(0.0, 5.0), min_size=len(steps), max_size=len(steps)))
    return np.cumsum(steps), np.array(weights)


@given(elements(), st.floats(-20.0, 20.0))
def test_at_rest_they_hold_what_is_missing_as_far_as_they_can(of, missing):
    radii, weights = of
    stretch = stretched_at_start(np.array(missing), np.array(0.0), radii, weights)
    held, most = np.sum(weights * stretch / radii), weights.sum()
    assert held == pytest.approx(np.clip(missing, -most, most), abs=1e-9)
    assert (np.abs(stretch) <= radii).all()
    # as if it came there from where nothing was stretched: those that do not slip are alike
    furthest = np.abs(stretch).max()
    np.testing.assert_allclose(np.abs(stretch), np.minimum(furthest, radii), atol=1e-12)


@given(elements(), st.floats(-20.0, 20.0), st.sampled_from([-1.0, 1.0]))
def test_in_motion_they_slip(of, missing, way):
    radii, weights = of
    stretch = stretched_at_start(np.array(missing), np.array(way), radii, weights)
    np.testing.assert_allclose(stretch, way * radii)


def test_rows_are_stretched_each_by_its_own(tmp_path):
    radii, rng = np.array([0.1, 0.3, 0.4]), np.random.default_rng(0)
    missing, dq = rng.normal(size=20), np.repeat([0.0, 1.0], 10)
    weights = rng.uniform(0, 1, (20, 3))
    together = stretched_at_start(missing, dq, radii, weights)
    alone = [
        stretched_at_start(*one, radii, own)
        for one, own in zip(zip(missing, dq, strict=True), weights, strict=True)
    ]
    np.testing.assert_allclose(together, alone)


def held(tmp_path, share):
    """How far a pendulum goes in a second that hysteresis holds with a share of what it needs."""
    robot = pendulum(tmp_path)
    at = np.array([0.0, 0.05, 0.2])
    law = Law(HYSTERESIS, "hinge", "distance", "hinge")
    torque = -share * NEEDED * np.array([0.0, 0.7, 1.0])
    model = Model(robot, learned=(Curve(law, tuple(at), tuple(torque)),))
    # commanded to be where it is, so that the motor gives nothing
    q = predict(recording(robot, hold(AWAY)), model=model)
    return np.abs(q - AWAY).max()


def test_what_holds_a_joint_at_rest_keeps_it_there(tmp_path):
    assert held(tmp_path, 1.5) < 1e-9
    # the motor alone lets it sag
    assert held(tmp_path, 0.0) > 1e-2


def test_what_is_too_weak_to_hold_it_lets_it_go(tmp_path):
    assert 1e-3 < held(tmp_path, 0.5) < held(tmp_path, 0.0)
