import dataclasses
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.identify.noise_floor import _divided_differences, noise_floor, noise_of
from tests.diagnose.made import hold, recording, swing


def logged(q, name="made"):
    made = recording("none.xml", hold(0.0), name, duration_s=0.1)
    q = np.asarray(q, float).reshape(len(q), -1)
    time = np.arange(len(q)) / 200
    return dataclasses.replace(made, time=time, q_des=np.zeros_like(q), q=q)


def smooth(n, amplitude=0.5, hz=0.7):
    return swing(amplitude, hz)(np.arange(n) / 200)


@settings(deadline=None, max_examples=25)
@given(
    st.floats(-11, -4).map(np.exp),
    st.floats(0.0, 1.0),
    st.floats(0.3, 1.5),
    st.integers(0, 2**32 - 1),
)
def test_white_noise_on_a_smooth_motion_is_recovered(sigma, amplitude, hz, seed):
    noise = sigma * np.random.default_rng(seed).normal(size=4000)
    found = noise_floor([logged(smooth(4000, amplitude, hz) + noise)])
    assert found == pytest.approx(sigma, rel=0.15)


@settings(deadline=None, max_examples=25)
@given(st.floats(-9, -5).map(np.exp), st.integers(0, 2**32 - 1))
def test_an_encoders_step_costs_its_rounding(step, seed):
    """Whether the joint moves fast over many steps or slowly over few."""
    rng = np.random.default_rng(seed)
    for span in (20, 2000):
        q = smooth(1000, span * step, rng.uniform(0.5, 1.0))
        found = noise_floor([logged(np.round(q / step) * step)])
        assert found == pytest.approx(step / np.sqrt(12), rel=0.25)


def test_a_joint_that_rests_after_a_motion_hides_its_noise_but_not_its_step():
    step = 1e-3
    motion = smooth(200, 0.3)
    q = np.concatenate([motion, np.full(2000, motion[-1])])
    found = noise_floor([logged(np.round(q / step) * step)])
    assert found == pytest.approx(step / np.sqrt(12), rel=0.05)


def test_noise_and_rounding_together():
    sigma = step = 1e-4
    rng = np.random.default_rng(0)
    q = np.round((smooth(2000) + sigma * rng.normal(size=2000)) / step) * step
    assert noise_floor([logged(q)]) == pytest.approx(np.hypot(sigma, step / 12**0.5), rel=0.1)


def test_joints_and_recordings_count_by_their_samples():
    rng = np.random.default_rng(0)
    sigmas = np.array([1e-4, 4e-4])
    q = smooth(4000)[:, None] + sigmas * rng.normal(size=(4000, 2))
    q[1::4, 0] = q[2::4, 0] = q[3::4, 0] = np.nan
    expected = np.sqrt((sigmas[0] ** 2 + 4 * sigmas[1] ** 2) / 5)
    assert noise_floor([logged(q)]) == pytest.approx(expected, rel=0.1)
    halves = [logged(q[:2000]), logged(q[2000:])]
    assert noise_floor(halves) == pytest.approx(expected, rel=0.1)


def test_what_a_model_predicts_is_no_noise():
    """A jerky motion looks noisy by itself, and not once the prediction is taken off."""
    rng = np.random.default_rng(0)
    jerky = np.cumsum(rng.choice([-0.01, 0.01], 2000))
    noise = 1e-4 * rng.normal(size=2000)
    made = logged(jerky + noise)
    assert noise_floor([made]) > 3e-4
    assert noise_floor([made], [noise[:, None]]) == pytest.approx(1e-4, rel=0.15)


def test_a_model_that_is_wrong_is_no_noise_either():
    """Its smooth error stays out of the floor, however large."""
    rng = np.random.default_rng(0)
    noise = 1e-4 * rng.normal(size=2000)
    made = logged(smooth(2000) + noise)
    wrong = (noise + 0.05 * np.sin(np.arange(2000) / 50))[:, None]
    assert noise_floor([made], [wrong]) == pytest.approx(1e-4, rel=0.15)


def test_without_noise_there_is_no_floor():
    assert noise_floor([logged(smooth(1000))]) < 1e-7


LATE = st.lists(st.floats(0.0, 0.8), min_size=60, max_size=60).map(np.array)


@settings(deadline=None, max_examples=25)
@given(LATE, st.integers(2, 5), st.integers(0, 2**32 - 1))
def test_divided_differences_of_a_polynomial_vanish_whenever_its_samples_were_taken(late, d, seed):
    time = (np.arange(60) + late) / 200
    q = np.polyval(np.random.default_rng(seed).normal(size=d), time)
    assert np.abs(_divided_differences(q, time, d)).max() < 1e-9


@pytest.mark.parametrize("d", [2, 3, 4, 5])
def test_divided_differences_of_even_samples_are_differences_of_unit_weight(d):
    q, time = np.random.default_rng(0).normal(size=50), np.arange(50) / 200
    expected = np.diff(q, d) / np.sqrt(comb(2 * d, d))
    np.testing.assert_allclose(np.abs(_divided_differences(q, time, d)), np.abs(expected))


@settings(deadline=None, max_examples=25)
@given(st.floats(-11, -7).map(np.exp), st.floats(0.0, 1e-3), st.integers(0, 2**32 - 1))
def test_noise_is_recovered_from_rows_that_come_late(sigma, late_s, seed):
    rng = np.random.default_rng(seed)
    time = np.arange(4000) / 200 + np.minimum(rng.exponential(late_s, 4000), 0.8 / 200)
    q = swing(0.5, 0.7)(time) + sigma * rng.normal(size=4000)
    late = dataclasses.replace(logged(q), time=time)
    assert noise_floor([late], divided=True) == pytest.approx(sigma, rel=0.2)


@pytest.mark.parametrize(("sigma", "step"), [(0.005, 0.0), (0.0, 0.02), (0.01, 0.02)])
def test_the_noise_of_one_signal_is_that_of_its_samples_and_their_step(sigma, step):
    rng, time = np.random.default_rng(0), np.arange(800) / 200
    velocity = 2 * np.cos(4 * time) + sigma * rng.standard_normal(800)
    if step:
        velocity = step * np.round(velocity / step)
    assert noise_of(velocity, time) == pytest.approx(np.hypot(sigma, step / 12**0.5), rel=0.15)
