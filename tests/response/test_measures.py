import numpy as np
import pytest

from t2l.response.frequency_response import frequency_response
from t2l.response.lag import lag
from t2l.response.overshoot import overshoot
from t2l.response.region import REGIONS, region

RNG = np.random.default_rng


def smooth(t):
    return np.sin(2 * np.pi * 0.6 * t) + 0.4 * np.sin(2 * np.pi * 1.7 * t + 1.0)


@pytest.mark.parametrize("late", [0.0, 0.004, 0.033, 0.21])
def test_lag_is_found_between_samples(late):
    time = np.arange(0, 12, 0.02)
    found = lag([(smooth(time), 0.7 * smooth(time - late) + 0.1)], 0.02, RNG(0))
    assert found.seconds == pytest.approx(late, abs=2e-3)
    assert found.interval[0] - 2e-3 <= late <= found.interval[1] + 2e-3


def test_what_does_not_follow_has_no_lag():
    time = np.arange(0, 4, 0.02)
    assert lag([(np.zeros_like(time), smooth(time))], 0.02, RNG(0)) is None


def test_gain_and_phase_are_those_of_the_sines():
    time = np.arange(0, 32, 0.02)
    command = np.sin(2 * np.pi * 0.5 * time) + np.sin(2 * np.pi * 1.5 * time)
    motion = 0.8 * np.sin(2 * np.pi * 0.5 * time - 0.3) + 0.4 * np.sin(2 * np.pi * 1.5 * time - 1)
    found = frequency_response([(command, motion)], 0.02)
    for hz, gain, phase in ((0.5, 0.8, -0.3), (1.5, 0.4, -1.0)):
        i = int(np.argmin(np.abs(found.hz - hz)))
        assert found.gain[i] == pytest.approx(gain, rel=0.02)
        assert found.phase_rad[i] == pytest.approx(phase, abs=0.02)
        assert found.coherence[i] > 0.99


def test_overshoot_of_a_known_damping_ratio():
    time = np.arange(0, 4, 0.01)
    zeta, omega = 0.4, 20.0
    damped, since = omega * np.sqrt(1 - zeta**2), np.maximum(time - 1, 0)
    q = 1 - np.exp(-zeta * omega * since) * (
        np.cos(damped * since) + zeta * omega / damped * np.sin(damped * since)
    )
    command = np.where(time >= 1, 1.0, 0.0)
    found = overshoot([(time, command, q)], 1e-3, RNG(0))
    assert found.steps == 1
    expected = np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2))
    assert found.fraction == pytest.approx(expected, abs=0.01)


def test_a_smooth_command_has_no_steps():
    time = np.arange(0, 4, 0.01)
    assert overshoot([(time, smooth(time), smooth(time))], 1e-3, RNG(0)) is None


@pytest.mark.parametrize(
    ("hz", "zeta", "name"), [(1.0, 2.0, "CO"), (5.0, 2.0, "SO"), (1.0, 0.5, "CU"), (5.0, 0.5, "SU")]
)
def test_regions(hz, zeta, name):
    found = region(2 * np.pi * hz, zeta, np.diag([0.01, 0.01]), 2.0)
    assert found.name == name
    assert found.certain
    assert sum(found.probability.values()) == pytest.approx(1.0)


def test_a_region_is_uncertain_near_its_border_and_where_nothing_is_told():
    near = region(2 * np.pi * 2.02, 0.5, np.diag([0.01, 0.01]), 2.0)
    assert not near.certain
    assert near.probability["SU"] == pytest.approx(0.54, abs=0.01)
    told = region(30.0, 3.0, np.full((2, 2), np.inf), 2.0)
    assert not told.certain
    assert set(told.probability) == set(REGIONS)
