"""How far a simulated motion is from a measured one."""

import numpy as np


def spectral_error(difference: np.ndarray) -> np.ndarray:
    """Mean squared discrete Fourier transform of simulated minus measured, as the study's loss.

    The transforms are unitary, so that by Parseval's theorem this is the mean squared error over
    time; what the study weighs by frequency, it weighs alike.

    Args:
        difference: (n, ntime, njoint).

    Returns:
        (n,), infinite where a simulation is not finite.
    """
    # not scipy.signal.periodogram: its density per hertz would only have to be scaled back
    square = np.abs(np.fft.rfft(difference, axis=1, norm="ortho")) ** 2
    # the transform of a real signal repeats all but the first and, if even, the middle frequency
    _, ntime, njoint = difference.shape
    weight = np.full(square.shape[1], 2.0)
    weight[0] = 1.0
    if ntime % 2 == 0:
        weight[-1] = 1.0
    error = np.einsum("nfj,f->n", square, weight) / (ntime * njoint)
    return np.where(np.isfinite(error), error, np.inf)


def mean_squared_error(simulated: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """(n,) mean over time and joints of (simulated − measured)²."""
    return np.mean((simulated - measured) ** 2, axis=(1, 2))
