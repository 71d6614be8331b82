"""The state a recording starts in, from noisy measurements.

The slope of the first positions, or the first of the velocities where they are logged, says whether
a log begins in motion, and about how fast. To follow it to the noise of an encoder takes more:
`t2l.identify.hidden_state`, which begins there.
"""

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.identify.block_bootstrap import BEYOND_CHANCE
from t2l.identify.noise_floor import noise_floor, noise_of
from t2l.recordings.recording import Recording

WINDOWS = (4, 6, 9, 13, 19, 28)  # numerics: samples through which a cubic is laid
AGREE = BEYOND_CHANCE  # standard errors within which slopes of a longer and a shorter window agree
CLEAR = 7.0  # tuned: likewise, by which a joint that moves differs from one at rest


class Slope(NamedTuple):
    """Velocity of a joint at its first sample.

    Attributes:
        rad_s: it.
        error: its standard error, rad/s.
        clear: whether it clearly is not zero.
    """

    rad_s: float = 0.0
    error: float = 0.0
    clear: bool = False


_known: WeakKeyDictionary[Recording, tuple[Slope, ...]] = WeakKeyDictionary()


def start_state(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Measured position and velocity (njoint,) at the start, zero where a joint hardly moves."""
    dq = np.array([slope.rad_s if slope.clear else 0.0 for slope in _slopes(recording)])
    return _first_measured(recording.q), dq


def begins_in_motion(recording: Recording) -> bool:
    """Whether any joint clearly does."""
    return bool((np.abs(start_state(recording)[1]) > AT_REST_RAD_S).any())


def half_begin_in_motion(recordings: Sequence[Recording]) -> bool:
    """Whether at least half clearly do: then any of them may, however slowly."""
    return 2 * sum(map(begins_in_motion, recordings)) >= len(recordings)


def slope_of_motion(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Velocity at the start of a recording that begins in motion, and what it may be off by.

    (njoint,) each. Velocities count whether or not they are clear.
    """
    slopes = _slopes(recording)
    doubt = np.array([AGREE * slope.error for slope in slopes])
    return np.array([slope.rad_s for slope in slopes]), doubt


def first_slope(
    time: np.ndarray, values: np.ndarray, noise: float, velocities: bool = False
) -> Slope:
    """Velocity at the first of some samples of one joint.

    The window of a cubic grows while it agrees there with those of all shorter ones: noise
    shrinks with it and what no cubic can follow is noticed (Lepski, 1990).

    Args:
        values: rad, or rad/s if they are `velocities`; so is the noise of each.
    """
    slopes: list[float] = []
    errors: list[float] = []
    for n in WINDOWS:
        if n > len(values):
            break
        slope, error = _slope(time[:n] - time[0], values[:n], noise, velocities)
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
        parabola = np.polyfit(time[:3] - time[0], values[:3], 2)[1 + velocities]
        clear = clear and abs(slope) >= CLEAR * abs(slope - parabola)
    return Slope(slope, error, bool(clear))


def _slopes(recording: Recording) -> tuple[Slope, ...]:
    """Of each joint."""
    if recording not in _known:
        dq = np.full_like(recording.q, np.nan) if recording.dq is None else recording.dq
        logged = ~np.isnan(dq)
        noise = 0.0 if logged.any(axis=0).all() else noise_floor([recording], divided=True)
        first = []
        for j, velocities in enumerate(logged.any(axis=0)):
            rows = np.flatnonzero(logged[:, j] if velocities else ~np.isnan(recording.q[:, j]))
            values, time = (dq if velocities else recording.q)[rows, j], recording.time[rows]
            off = noise_of(values, time) if velocities else noise
            some = slice(WINDOWS[-1])
            first.append(first_slope(time[some], values[some], off, bool(velocities)))
        _known[recording] = tuple(first)
    return _known[recording]


def _slope(
    t: np.ndarray, values: np.ndarray, noise: float, velocities: bool
) -> tuple[float, float]:
    """Slope at t = 0 of the cubic through positions, or its value there; and the standard error."""
    powers, place = np.vander(t / t[-1], 4), 2 + velocities
    inverse, unit = np.linalg.inv(powers.T @ powers), 1.0 if velocities else t[-1]
    found = (inverse @ (powers.T @ values))[place] / unit
    return float(found), noise * float(np.sqrt(inverse[place, place])) / unit


def _first_measured(values: np.ndarray) -> np.ndarray:
    """The first number of each column (n, njoint); NaN where there is none."""
    return values[np.argmax(~np.isnan(values), axis=0), np.arange(values.shape[1])]
