"""The velocity with which a recording starts, read off noisy positions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.identify.initial_state import first_slope

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


def test_a_joint_at_rest_starts_at_rest():
    assert [first_slope(*swing(0.0, seed=s), NOISE_RAD) for s in range(300)].count(0.0) >= 299


@pytest.mark.parametrize("acceleration", [1.0, 30.0])
def test_a_joint_that_sets_off_at_the_first_sample_starts_at_rest(acceleration):
    slopes = [first_slope(*falling(acceleration, seed=s), NOISE_RAD) for s in range(100)]
    assert slopes.count(0.0) >= 99


@pytest.mark.parametrize("speed", [0.3, 1.0, -3.0])
def test_a_joint_in_motion_starts_at_its_speed(speed):
    slopes = np.array([first_slope(*swing(speed, seed=s), NOISE_RAD) for s in range(100)])
    assert np.median(np.abs(slopes - speed)) < 0.03
    assert np.count_nonzero(slopes) >= 95


@given(speed=st.floats(-5, 5), shift=st.floats(-3, 3), seed=st.integers(0, 99))
@settings(deadline=None, max_examples=50)
def test_neither_the_clock_nor_the_zero_of_the_encoder_matters(speed, shift, seed):
    time, q = swing(speed, seed=seed)
    here, there = first_slope(time, q, NOISE_RAD), first_slope(time + 7.0, q + shift, NOISE_RAD)
    assert there == pytest.approx(here, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_too_few_samples_tell_no_speed(n):
    assert first_slope(*swing(2.0, n=n), NOISE_RAD) == 0.0
