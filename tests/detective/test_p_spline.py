"""A curve whose second derivative is constant between ticks and may jump there."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.detective.p_spline import p_spline

PERIOD_S, NOISE = 1e-3, 1e-4


def moved(acceleration):
    """Position and velocity at ticks, of accelerations from each to the next."""
    dq = np.r_[0.0, np.cumsum(acceleration[:-1]) * PERIOD_S]
    return np.r_[0.0, np.cumsum((dq[1:] + dq[:-1]) / 2) * PERIOD_S], dq


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
def test_a_parabola_is_followed_whatever_it_is(numbers):
    at = np.arange(500) * PERIOD_S
    clock = at[3::7]
    found = p_spline(clock, np.polyval(numbers, clock), at)
    inside = (at >= clock[0]) & (at <= clock[-1])
    assert found.value[inside] == pytest.approx(np.polyval(numbers, at[inside]), abs=1e-6)
    slope = np.polyval(np.polyder(numbers), at[inside])
    assert found.slope[inside] == pytest.approx(slope, abs=1e-4)


def test_what_jumps_is_followed_through_noise_and_how_well_is_known():
    at, rng = np.arange(3000) * PERIOD_S, np.random.default_rng(0)
    q, dq = moved(np.where((at > 0.7) & (at < 1.5), 5.0, -2.0))
    rows = np.arange(5, len(at) - 5, 10)
    found = p_spline(at[rows], q[rows] + NOISE * rng.normal(size=len(rows)), at)
    inside = slice(rows[0], rows[-1] + 1)
    assert np.sqrt(np.mean((found.value - q)[inside] ** 2)) < 0.8 * NOISE
    off = np.sqrt(np.mean((found.slope - dq)[inside] ** 2))
    assert off < 0.01
    assert 0.2 * off < found.slope_error < 2 * off


def test_too_few_samples_say_nothing():
    assert p_spline(np.arange(4.0), np.zeros(4), np.arange(4.0)) is None
    assert p_spline(np.zeros(0), np.zeros(0), np.arange(4.0)) is None
