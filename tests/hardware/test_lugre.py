import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.hardware.lugre import LuGre

FRICTION = LuGre(
    *(np.array([value]) for value in (1e4, 44.0, 1.0, 1.4, 0.02)),
)


def slide(velocity, period_s, seconds=0.1):
    bent = np.zeros(1)
    for _ in range(round(seconds / period_s)):
        bent, torque = FRICTION.advance(bent, np.array([velocity]), period_s)
    return float(bent[0]), float(torque[0])


@given(st.floats(-3, 3).filter(lambda v: abs(v) > 0.05), st.sampled_from([1e-4, 2.5e-4, 1e-3]))
def test_steady_sliding_feels_the_stribeck_curve_at_any_period(velocity, period_s):
    _, torque = slide(velocity, period_s)
    expected = -np.sign(velocity) * FRICTION.level(np.array([velocity]))[0]
    assert torque == pytest.approx(expected, rel=1e-6)


def test_before_it_slides_a_joint_is_held_by_a_spring():
    bent, torque = np.zeros(1), np.zeros(1)
    for _ in range(100):  # 10 µrad in all, a hundredth of what breaks it loose
        bent, torque = FRICTION.advance(bent, np.array([1e-4]), 1e-3)
    assert bent[0] == pytest.approx(1e-5, rel=0.1)
    assert torque[0] == pytest.approx(-(1e4 * 1e-5 + 44.0 * 1e-4), rel=0.1)


@given(st.lists(st.floats(-2, 2), min_size=1, max_size=50))
def test_bristles_never_bend_further_than_breakaway(velocities):
    bent = np.zeros(1)
    for velocity in velocities:
        bent, _ = FRICTION.advance(bent, np.array([velocity]), 2.5e-4)
        assert abs(bent[0]) <= 1.4 / 1e4 * (1 + 1e-9)
