"""An oscillation in time that no command explains: the same frequency in every recording."""

import numpy as np

from t2l.identify.levels import MATERIAL

FREQUENCIES_HZ = (0.2, 8.0)  # bound: looked at, as far as the recordings' length and rate allow
LEAST_CYCLES = 1.5  # bound: in the shortest recording; fewer are no oscillation
PURER = MATERIAL  # by how much more of it must be the sine than of the command, to be no motion
MOST_SAMPLES = 4000  # numerics: enough for the highest frequency over four minutes


def swing(
    values: np.ndarray, command: np.ndarray, time: np.ndarray, recording: np.ndarray
) -> tuple[float, float]:
    """The frequency whose sine, of a phase of its own in each recording, tells most of values.

    Args:
        values, command, time, recording: (n,) what swings, the commanded position, s since the
            recording's start, index.

    Returns:
        Frequency in Hz and the fraction of the sum of values² that the sines tell; (0, 0) where
        no frequency can be looked at.
    """
    every = 1 + len(values) // MOST_SAMPLES
    values, command, time = values[::every], command[::every], time[::every]
    _, recording = np.unique(recording[::every], return_inverse=True)
    last = np.zeros(recording.max() + 1)
    np.maximum.at(last, recording, time)
    rate = np.bincount(recording).min() / last.max() if last.max() > 0 else 0.0
    low = max(FREQUENCIES_HZ[0], LEAST_CYCLES / max(last.min(), 1e-9))
    high = min(FREQUENCIES_HZ[1], rate / 4)  # numerics: four samples a period
    total = np.sum(values**2)
    if low >= high or not total > 0:
        return 0.0, 0.0
    frequencies = np.arange(low, high, 0.2 / last.max())  # numerics: of a period at the end
    told = np.array([_told(f, (values, command), time, recording) for f in frequencies])
    spread = np.array([np.sum(_centred(v, recording) ** 2) for v in (values, command)])
    part = told / np.maximum(spread, 1e-300)
    fractions = np.where(part[:, 0] > part[:, 1] + PURER, told[:, 0] / total, 0.0)
    best = int(np.argmax(fractions))
    return float(frequencies[best]), float(fractions[best])


def _centred(values: np.ndarray, recording: np.ndarray) -> np.ndarray:
    return values - (np.bincount(recording, values) / np.bincount(recording))[recording]


def _told(frequency, signals, time, recording) -> list[float]:
    """Sum of squares that a sine and a cosine in each recording take off each signal."""
    # not scipy.signal.lombscargle: it knows one series, and takes seconds to import
    phase = 2 * np.pi * frequency * time
    sine, cosine = (_centred(wave, recording) for wave in (np.sin(phase), np.cos(phase)))
    ss, cc, sc = (
        np.bincount(recording, a * b) for a, b in ((sine, sine), (cosine, cosine), (sine, cosine))
    )
    determinant = np.maximum(ss * cc - sc**2, 1e-12)
    sums = []
    for signal in signals:
        sy, cy = np.bincount(recording, sine * signal), np.bincount(recording, cosine * signal)
        sums.append(float(np.sum((cc * sy**2 - 2 * sc * sy * cy + ss * cy**2) / determinant)))
    return sums
