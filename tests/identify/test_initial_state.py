"""The velocity with which a recording starts, read off noisy positions."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.identify.initial_state import (
    begins_in_motion,
    first_slope,
    half_begin_in_motion,
    slope_of_motion,
    start_state,
)
from tests.diagnose.made import hold, recording

NOISE_RAD = 1e-4
RATE_HZ = 200.0


def swing(speed, frequency_hz=2.0, n=40, seed=0):
    """Samples of a motion that starts at `speed` rad/s, with encoder noise."""
    time = np.arange(n) / RATE_HZ
    omega = 2 * np.pi * frequency_hz
    noise = NOISE_RAD * np.random.default_rng(seed).standard_normal(n)
    return time, speed / omega * np.sin(omega * time) + noise


def falling(acceleration, n=40, seed=0):
    """Samples of a motion that starts at rest under a constant torque."""
    time, noise = swing(0.0, n=n, seed=seed)
    return time, noise + 0.5 * acceleration * time**2


def speed_of(time, q):
    """rad/s, zero unless the joint clearly moves."""
    slope = first_slope(time, q, NOISE_RAD)
    return slope.rad_s if slope.clear else 0.0


def test_a_joint_at_rest_starts_at_rest():
    assert [speed_of(*swing(0.0, seed=s)) for s in range(300)].count(0.0) >= 299


@pytest.mark.parametrize("acceleration", [1.0, 30.0])
def test_a_joint_that_sets_off_at_the_first_sample_starts_at_rest(acceleration):
    slopes = [speed_of(*falling(acceleration, seed=s)) for s in range(100)]
    assert slopes.count(0.0) >= 99


@pytest.mark.parametrize("speed", [0.3, 1.0, -3.0])
def test_a_joint_in_motion_starts_at_its_speed(speed):
    slopes = np.array([speed_of(*swing(speed, seed=s)) for s in range(100)])
    assert np.median(np.abs(slopes - speed)) < 0.03
    assert np.count_nonzero(slopes) >= 95


@given(speed=st.floats(-5, 5), shift=st.floats(-3, 3), seed=st.integers(0, 99))
@settings(deadline=None, max_examples=50)
def test_neither_the_clock_nor_the_zero_of_the_encoder_matters(speed, shift, seed):
    time, q = swing(speed, seed=seed)
    here, there = speed_of(time, q), speed_of(time + 7.0, q + shift)
    assert there == pytest.approx(here, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_too_few_samples_tell_no_speed(n):
    assert first_slope(*swing(2.0, n=n), NOISE_RAD) == (0.0, 0.0, False)


@pytest.mark.parametrize("late_s", [0.0, 1e-3])
@pytest.mark.parametrize("speed", [0.0, 0.3])
def test_late_rows_hide_no_motion_and_feign_none(late_s, speed):
    """Whatever moves later: what lateness does there is no noise."""
    begin = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        time = np.arange(600) / RATE_HZ
        time[1:] += np.minimum(rng.exponential(late_s, 599), 0.8 / RATE_HZ)
        q = speed * time + np.where(time > 0.3, np.sin(9 * (time - 0.3)), 0.0)
        q = q + NOISE_RAD * rng.standard_normal(600)
        made = recording("none.xml", hold(0.0))
        made = dataclasses.replace(made, time=time, q=q[:, None], q_des=np.zeros((600, 1)))
        begin.append(begins_in_motion(made))
    assert np.mean(begin) == (speed > 0)


def test_a_log_of_a_set_in_motion_begins_with_its_slope_however_slow():
    made = recording("none.xml", hold(0.0), row_rate_hz=RATE_HZ)
    _, q = swing(0.015, n=len(made.q))
    slow = dataclasses.replace(made, q=q[:, None])
    assert not begins_in_motion(slow)
    dq, doubt = slope_of_motion(slow)
    assert 0 < abs(dq[0] - 0.015) < doubt[0] < 0.05


@pytest.mark.parametrize("rad_s", [0.0, 0.7])
def test_a_measured_velocity_is_as_sure_as_its_noise(rad_s):
    made, rng = recording("none.xml", hold(0.0)), np.random.default_rng(0)
    noisy = rad_s + 0.005 * rng.standard_normal(made.q.shape)
    noisy[0] = rad_s + 0.01
    log = dataclasses.replace(made, dq=noisy)
    dq, doubt = slope_of_motion(log)
    assert abs(dq - rad_s) < doubt < 0.02
    # at rest the noise of one sample is no motion
    assert begins_in_motion(log) == (rad_s > 0)
    assert start_state(log)[1] == (dq if rad_s else 0.0)


def test_a_velocity_without_noise_is_not_in_doubt():
    made = recording("none.xml", hold(0.0))
    dq, doubt = slope_of_motion(dataclasses.replace(made, dq=np.full_like(made.q, 0.7)))
    assert dq == pytest.approx([0.7], abs=1e-9)
    assert doubt == pytest.approx([0.0], abs=1e-9)


def test_half_of_a_set_say_that_all_may_begin_in_motion():
    made = recording("none.xml", hold(0.0))
    fast = dataclasses.replace(made, dq=np.full_like(made.q, 0.7))
    assert half_begin_in_motion([fast, made])
    assert not half_begin_in_motion([fast, made, made])
