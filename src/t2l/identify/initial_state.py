"""The state a recording starts in, from noisy positions.

A slope through the first positions says whether a log begins in motion, and about how fast. To
follow it to the noise of an encoder takes more: `t2l.identify.hidden_state`, which begins there.
"""

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.identify.block_bootstrap import BEYOND_CHANCE
from t2l.identify.noise_floor import noise_floor
from t2l.recordings.recording import Recording

WINDOWS = (4, 6, 9, 13, 19, 28)  # numerics: samples through which a cubic is laid
AGREE = BEYOND_CHANCE  # standard errors within which slopes of a longer and a shorter window agree
CLEAR = 7.0  # tuned: likewise, by which a joint that moves differs from one at rest


class Slope(NamedTuple):
    """Of the first positions of a joint.

    Attributes:
        rad_s: at the first sample.
        error: its standard error, rad/s.
        clear: whether it clearly is not zero.
    """

    rad_s: float = 0.0
    error: float = 0.0
    clear: bool = False


_known: WeakKeyDictionary[Recording, tuple[Slope | None, ...]] = WeakKeyDictionary()


def start_state(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Measured position and velocity (njoint,) at the start.

    Where velocity was not measured, it is the slope of the first measured positions if they
    clearly move, and zero if they do not.
    """
    dq = _measured_velocity(recording)
    for j, slope in enumerate(_slopes(recording)):
        if slope is not None:
            dq[j] = slope.rad_s if slope.clear else 0.0
    return _first_measured(recording.q), dq


def begins_in_motion(recording: Recording) -> bool:
    """Whether any joint clearly does."""
    return bool((np.abs(start_state(recording)[1]) > AT_REST_RAD_S).any())


def half_begin_in_motion(recordings: Sequence[Recording]) -> bool:
    """Whether at least half clearly do: then any of them may, however slowly."""
    return 2 * sum(map(begins_in_motion, recordings)) >= len(recordings)


def slope_of_motion(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Velocity at the start of a recording that begins in motion, and what it may be off by.

    (njoint,) each. Slopes count whether or not they are clear; what was measured is off by zero.
    """
    dq = _measured_velocity(recording)
    doubt = np.zeros_like(dq)
    for j, slope in enumerate(_slopes(recording)):
        if slope is not None:
            dq[j], doubt[j] = slope.rad_s, AGREE * slope.error
    return dq, doubt


def first_slope(time: np.ndarray, q: np.ndarray, noise_rad: float) -> Slope:
    """The slope of some samples of one joint.

    The window of a cubic grows while its slope agrees with those of all shorter ones: noise
    shrinks with it and what no cubic can follow is noticed (Lepski, 1990).
    """
    slopes: list[float] = []
    errors: list[float] = []
    for n in WINDOWS:
        if n > len(q):
            break
        slope, error = _slope(time[:n] - time[0], q[:n], noise_rad)
        if any(abs(slope - s) > AGREE * e for s, e in zip(slopes, errors, strict=True)):
            break
        slopes.append(slope)
        errors.append(error)
    if not slopes:
        return Slope()
    # the longest window may just not show yet that a cubic fails
    slope, error = slopes[-1], errors[max(len(errors) - 2, 0)]
    clear = abs(slope) > max(AT_REST_RAD_S, CLEAR * error)
    if len(slopes) == 1:
        parabola = np.polyfit(time[:3] - time[0], q[:3], 2)[1]
        clear = clear and abs(slope) >= CLEAR * abs(slope - parabola)
    return Slope(slope, error, bool(clear))


def _slopes(recording: Recording) -> tuple[Slope | None, ...]:
    """Of each joint; None where velocity was measured."""
    if recording not in _known:
        sloped = np.isnan(_measured_velocity(recording))
        noise = noise_floor([recording], divided=True) if sloped.any() else 0.0
        first = []
        for j, needed in enumerate(sloped):
            rows = np.flatnonzero(~np.isnan(recording.q[:, j]))[: WINDOWS[-1]]
            slope = first_slope(recording.time[rows], recording.q[rows, j], noise)
            first.append(slope if needed else None)
        _known[recording] = tuple(first)
    return _known[recording]


def _slope(t: np.ndarray, q: np.ndarray, noise_rad: float) -> tuple[float, float]:
    """Slope at t = 0 of the cubic through q, and its standard error."""
    powers = np.vander(t / t[-1], 4)
    inverse = np.linalg.inv(powers.T @ powers)
    slope = (inverse @ (powers.T @ q))[2] / t[-1]
    return float(slope), noise_rad * float(np.sqrt(inverse[2, 2])) / t[-1]


def _measured_velocity(recording: Recording) -> np.ndarray:
    """(njoint,), NaN where it was not."""
    unmeasured = np.full_like(recording.q, np.nan)
    return _first_measured(unmeasured if recording.dq is None else recording.dq)


def _first_measured(values: np.ndarray) -> np.ndarray:
    """The first number of each column (n, njoint); NaN where there is none."""
    return values[np.argmax(~np.isnan(values), axis=0), np.arange(values.shape[1])]
