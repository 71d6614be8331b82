import numpy as np
import pytest
from benchmarks import advice
from hypothesis import given
from hypothesis import strategies as st

from t2l.advise.action_scale import action_scales
from t2l.advise.evidence import evidence
from t2l.advise.shown import RECORDED, Shown

STILL, LIMIT = np.zeros(2), np.array([5.0, 2.0])


def shown(speed=0.0, torque=0.0, count=4):
    t = np.arange(100)[:, None] / 50 * np.ones(2)
    rows = np.full((100, 2), 1.0)
    q, dq, given = speed * t, speed * rows, torque * rows
    return Shown(50.0, [q] * count, [dq] * count, [given] * count, [q] * count, RECORDED)


def gains(kp, kd):
    return np.full((1, 2), kp), np.full((1, 2), kd)


@given(kp=st.floats(1, 1000), kd=st.floats(0, 100), speed=st.floats(0.01, 3))
def test_to_keep_a_speed_takes_damping_over_stiffness(kp, kd, speed):
    found = action_scales(shown(speed), *gains(kp, kd), STILL, LIMIT, 1)
    assert found.low[0] == pytest.approx([kd * speed / kp] * 2, abs=1e-9)
    assert found.high[0] == pytest.approx(LIMIT / kp)


def test_friction_and_torque_come_on_top():
    found = action_scales(shown(1.0, 3.0), *gains(10.0, 2.0), np.array([0.5, 0.0]), LIMIT, 1)
    assert found.low[0] == pytest.approx([0.55, 0.5])
    # the second has 0.2 rad for it
    assert found.room[0] == pytest.approx(0.2 / 0.5)


@given(factor=st.floats(0.01, 100))
def test_to_scale_torques_and_gains_changes_no_scale(factor):
    one = action_scales(shown(1.0, 3.0), *gains(10.0, 2.0), STILL + 0.1, LIMIT, 1)
    scaled = shown(1.0, 3.0 * factor), *gains(10.0 * factor, 2.0 * factor)
    other = action_scales(*scaled, factor * (STILL + 0.1), factor * LIMIT, 1)
    np.testing.assert_allclose(other.low, one.low, rtol=1e-9)
    np.testing.assert_allclose(other.high, one.high, rtol=1e-9)


@pytest.mark.slow
def test_the_kept_trials_are_what_the_benchmark_measures():
    for kept, found in zip(evidence().trials, advice.trials(), strict=True):
        assert (kept.inside, kept.outside) == (found.inside, found.outside)
        assert kept.inside_succeeded == pytest.approx(found.inside_succeeded, abs=1e-3)
