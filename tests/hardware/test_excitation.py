import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.hardware.excitation import (
    SMOOTH_STEP_PEAK_VELOCITY,
    chirp,
    envelope,
    multisine,
    point_to_point,
    sine,
    smooth_step,
    triangle,
)

TIME = np.arange(501) / 50
AMPLITUDE = np.array([0.1, 0.2, 0.0])


def test_a_sine_has_a_frequency_for_each_joint():
    q = sine(TIME, AMPLITUDE, np.array([0.5, 1.0, 2.0]))
    assert q.shape == (501, 3)
    assert q[25] == pytest.approx([0.1, 0, 0])
    assert q[12] == pytest.approx(
        [0.1 * np.sin(0.48 * np.pi / 2 * 1), 0.2 * np.sin(0.48 * np.pi), 0]
    )


def test_a_chirp_goes_from_one_frequency_to_the_other():
    fine = np.linspace(0, 10, 100_001)
    q = chirp(fine, AMPLITUDE, 0.5, 2.5, 10.0)
    crossings = fine[1:][np.diff(np.sign(q[:, 0])) > 0]
    assert 1 / np.diff(crossings)[0] == pytest.approx(0.7, abs=0.15)
    assert 1 / np.diff(crossings)[-1] == pytest.approx(2.5, abs=0.15)
    np.testing.assert_allclose(q[:, 1], 2 * q[:, 0])


@given(seed=st.integers(0, 1000))
def test_a_multisine_reaches_its_amplitude_and_depends_on_its_seed(seed):
    q = multisine(TIME, AMPLITUDE, [0.3, 0.7, 1.3], seed)
    np.testing.assert_allclose(np.abs(q).max(axis=0), AMPLITUDE)
    np.testing.assert_array_equal(q, multisine(TIME, AMPLITUDE, [0.3, 0.7, 1.3], seed))
    assert np.abs(q - multisine(TIME, AMPLITUDE, [0.3, 0.7, 1.3], seed + 1)).max() > 1e-3
    # joints do not move alike, or they could not be told apart
    assert abs(np.corrcoef(q[:, 0], q[:, 1])[0, 1]) < 0.999


def test_a_multisine_has_its_frequencies_and_no_others():
    q = multisine(TIME[:-1], AMPLITUDE, [0.3, 0.7, 1.3], seed=0)[:, 0]
    spectrum = np.abs(np.fft.rfft(q))
    assert np.fft.rfftfreq(500, 1 / 50)[spectrum > 1e-9] == pytest.approx([0.3, 0.7, 1.3])


def test_an_envelope_begins_and_ends_at_rest():
    e = envelope(TIME, 10.0, 1.0)
    assert e[0] == e[-1] == 0
    assert (e[50:-50] == 1).all()
    # of third order in time: velocity and acceleration vanish with it
    np.testing.assert_allclose(e[:3], 10 * TIME[:3] ** 3, rtol=0.1)
    np.testing.assert_allclose(e, e[::-1], atol=1e-12)


def test_the_peak_velocity_of_a_smooth_step():
    part = np.linspace(0, 1, 10_001)
    assert np.gradient(smooth_step(part), part).max() == pytest.approx(SMOOTH_STEP_PEAK_VELOCITY)


def test_a_triangle_has_one_speed_between_its_reversals():
    q = triangle(TIME, AMPLITUDE, np.array([0.25, 0.5, 1.0]))
    speed = np.abs(np.gradient(q[:, 0], TIME))
    assert np.abs(q).max(axis=0) == pytest.approx(AMPLITUDE)
    assert np.median(speed) == pytest.approx(4 * 0.25 * 0.1)
    assert np.sum(np.diff(np.sign(np.diff(q[:, 0]))) != 0) == 5


def test_moves_go_to_one_end_and_then_from_end_to_end_with_stops():
    q = point_to_point(TIME, AMPLITUDE, 0.6, 0.4)
    np.testing.assert_allclose(q[[0, 30, 49, 80, 99, 130]].T[0], [0, 0.1, 0.1, -0.1, -0.1, 0.1])
    assert np.abs(np.diff(q[30:50], axis=0)).max() < 1e-12
