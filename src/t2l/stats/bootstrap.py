"""Intervals by resampling units of replication (Efron and Tibshirani 1993, percentile method)."""

from collections.abc import Callable
from math import nan

import numpy as np

DRAWS = 4000  # a limit at 2.5 % then rests on 100 of them
# the shares below which the ends of a 95 % interval lie
ENDS = (0.025, 0.975)
FEWEST = 3  # units in a group: one shows no spread, two a single difference


def bootstrap_interval(
    statistic: Callable[..., np.ndarray], *samples: np.ndarray, paired: bool = False
) -> tuple[float, float]:
    """The 95 % interval of a statistic; NaN for too few units, or where one draw in 20 has none.

    Args:
        statistic: of arrays (draw, n), one for each sample, along the last axis.
        samples: (n,) each, numbers of independent units; resampled each by itself.
        paired: they are columns of the same units, and resampled together.
    """
    arrays = [np.asarray(sample, float) for sample in samples]
    if not _enough([len(a) for a in (arrays[:1] if paired else arrays)]):
        return nan, nan
    generator = np.random.default_rng(0)
    drawn, index = [], None
    for array in arrays:
        if index is None or not paired:
            index = generator.integers(len(array), size=(DRAWS, len(array)))
        drawn.append(array[index])
    values = statistic(*drawn)
    if np.isfinite(values).mean() < 0.95:
        return nan, nan
    low, high = np.nanquantile(values, ENDS)
    return float(low), float(high)


def mean(values: np.ndarray) -> np.ndarray:
    """Along the last axis."""
    return np.mean(values, axis=-1)


def difference(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Of the means, along the last axis."""
    return mean(values) - mean(others)


def log_ratio(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Of the means of positive numbers, along the last axis."""
    return np.log(mean(values)) - np.log(mean(others))


def ratio(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Of the geometric means of positive numbers, along the last axis."""
    return np.exp(difference(np.log(values), np.log(others)))


def _enough(sizes: list[int]) -> bool:
    """Whether the rarest resamples, the lowest unit n times, are rarer than the interval's ends."""
    return min(sizes) >= FEWEST and np.prod([float(n) ** -n for n in sizes]) < ENDS[0]
