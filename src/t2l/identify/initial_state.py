"""The state a recording starts in, from noisy positions."""

import numpy as np

from t2l.identify.noise_floor import noise_floor
from t2l.recordings.recording import Recording

WINDOWS = (4, 6, 9, 13, 19, 28)  # samples through which a cubic is laid
AGREE = 2.5  # standard errors within which the slopes of a longer and a shorter window agree
CLEAR = 7.0  # likewise, by which a joint that moves differs from one at rest
LEAST_RAD_S = 0.02  # a joint that starts slower starts at rest
CERTAIN = 5.0  # times what it differs from a parabola's: a slope from the shortest window alone


def start_state(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Measured position and velocity (njoint,) at the start.

    Where velocity was not measured, it is the slope of the first measured positions if they
    clearly move, and zero if they do not.
    """
    unmeasured = np.full_like(recording.q, np.nan)
    dq = _first_measured(unmeasured if recording.dq is None else recording.dq)
    sloped = np.flatnonzero(np.isnan(dq))
    noise = noise_floor([recording]) if len(sloped) else 0.0
    for j in sloped:
        rows = np.flatnonzero(~np.isnan(recording.q[:, j]))[: WINDOWS[-1]]
        dq[j] = first_slope(recording.time[rows], recording.q[rows, j], noise)
    return _first_measured(recording.q), dq


def first_slope(time: np.ndarray, q: np.ndarray, noise_rad: float) -> float:
    """Slope at the first sample, rad/s; zero unless it clearly is not.

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
        return 0.0
    slope = slopes[-1]
    if len(slopes) == 1:
        parabola = np.polyfit(time[:3] - time[0], q[:3], 2)[1]
        if abs(slope) < CERTAIN * abs(slope - parabola):
            return 0.0
    # the longest window may just not show yet that a cubic fails
    error = errors[max(len(errors) - 2, 0)]
    return slope if abs(slope) > max(LEAST_RAD_S, CLEAR * error) else 0.0


def _slope(t: np.ndarray, q: np.ndarray, noise_rad: float) -> tuple[float, float]:
    """Slope at t = 0 of the cubic through q, and its standard error."""
    powers = np.vander(t / t[-1], 4)
    inverse = np.linalg.inv(powers.T @ powers)
    slope = (inverse @ (powers.T @ q))[2] / t[-1]
    return float(slope), noise_rad * float(np.sqrt(inverse[2, 2])) / t[-1]


def _first_measured(values: np.ndarray) -> np.ndarray:
    """The first number of each column (n, njoint); NaN where there is none."""
    return values[np.argmax(~np.isnan(values), axis=0), np.arange(values.shape[1])]
