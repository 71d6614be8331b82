"""Motions that excite a robot: offsets from where it starts, beginning and ending at rest.

Each kind is a function of time to offsets, (n, njoint), within ±amplitude of every joint; an
envelope makes the first and the last of them, with their velocities and accelerations, zero.
"""

from collections.abc import Sequence

import numpy as np

from t2l.robots.minimum_jerk import PEAK_SPEED, minimum_jerk


def sine(time: np.ndarray, amplitude: np.ndarray, frequency_hz: np.ndarray) -> np.ndarray:
    """One frequency for each joint, all in phase.

    Args:
        time: s, (n,), from zero.
        amplitude: rad, (njoint,).
        frequency_hz: (njoint,).

    Returns:
        rad, (n, njoint).
    """
    return amplitude * np.sin(2 * np.pi * np.outer(time, frequency_hz))


def study_sine(ncommand: int, amplitude: float) -> np.ndarray:
    """The study's identification motion: A sin(π k / 50) at command k of 50 Hz, on every joint.

    As the study writes it, without an envelope; `sine` differs from it in the last digit.

    Returns:
        rad, (ncommand, 1).
    """
    return amplitude * np.sin(np.pi * np.arange(ncommand) / 50)[:, None]


def chirp(
    time: np.ndarray, amplitude: np.ndarray, from_hz: float, to_hz: float, duration_s: float
) -> np.ndarray:
    """A sine on every joint whose frequency changes linearly over `duration_s`.

    Returns:
        rad, (n, njoint).
    """
    cycles = from_hz * time + (to_hz - from_hz) * time**2 / (2 * duration_s)
    return np.outer(np.sin(2 * np.pi * cycles), amplitude)


def multisine(
    time: np.ndarray, amplitude: np.ndarray, frequencies_hz: Sequence[float], seed: int
) -> np.ndarray:
    """A sum of equally strong sines with random phases, other ones for every joint.

    The sum is scaled so that each joint's largest offset over `time` is its amplitude.

    Args:
        time: s, (n,).
        amplitude: rad, (njoint,).
        frequencies_hz: of the parts.
        seed: the same phases for the same seed.

    Returns:
        rad, (n, njoint).
    """
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0, 2 * np.pi, (len(frequencies_hz), len(amplitude)))
    total = np.zeros((len(time), len(amplitude)))
    for frequency, phase in zip(frequencies_hz, phases, strict=True):
        total += np.sin(2 * np.pi * frequency * time[:, None] + phase)
    return amplitude * total / np.abs(total).max(axis=0)


def triangle(time: np.ndarray, amplitude: np.ndarray, frequency_hz: np.ndarray) -> np.ndarray:
    """Sweeps at constant speed from one reversal to the next, all joints in phase.

    Args:
        frequency_hz: (njoint,).

    Returns:
        rad, (n, njoint).
    """
    cycles = np.outer(time, frequency_hz)
    return amplitude * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * cycles))


def point_to_point(
    time: np.ndarray, amplitude: np.ndarray, move_s: float, dwell_s: float
) -> np.ndarray:
    """Minimum-jerk moves from the start to one end, and then from end to end, with stops there.

    Returns:
        rad, (n, njoint).
    """
    period = move_s + dwell_s
    number = np.floor(time / period + 1e-9)
    target = np.where(number % 2 == 0, 1.0, -1.0)
    origin = np.where(number == 0, 0.0, -target)
    moved = smooth_step((time - number * period) / move_s)
    return np.outer(origin + (target - origin) * moved, amplitude)


def envelope(time: np.ndarray, duration_s: float, ramp_s: float) -> np.ndarray:
    """From 0 to 1 within the first `ramp_s` and back within the last, (n,).

    The ramps are minimum-jerk, so that velocity and acceleration are zero at both ends.
    """
    return smooth_step(np.minimum(time, duration_s - time) / ramp_s)


def smooth_step(part: np.ndarray) -> np.ndarray:
    """Minimum-jerk course from 0 to 1 as `part` goes from 0 to 1, and constant outside."""
    path, _, _ = minimum_jerk(np.clip(part, 0.0, 1.0))
    return path


# of a unit step in unit time
SMOOTH_STEP_PEAK_VELOCITY = PEAK_SPEED
