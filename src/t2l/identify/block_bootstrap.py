"""Whether an effect earns its place on data it has not seen."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

BLOCK_S = 0.5  # tuned: longer than residuals of a controlled joint remember
RESAMPLES = 2000  # statistics: ten of them lie beyond the decision level
DECISION_LEVEL = 0.005  # statistics: one-sided; some twenty effects are tried
# derived: standard errors of a difference that chance does not explain at that level
BEYOND_CHANCE = NormalDist().inv_cdf(1 - DECISION_LEVEL)


@dataclass(frozen=True)
class Improvement:
    """1 − rmse with / rmse without, on samples that fitted nothing.

    Attributes:
        ci95: bootstrap interval over blocks.
        lower: the bound at `DECISION_LEVEL` that decides.
    """

    fraction: float
    ci95: tuple[float, float]
    lower: float


def blocks(recording: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(nsample,) which block a sample belongs to: `BLOCK_S` of one recording, all joints."""
    number = np.floor(time / BLOCK_S).astype(int)
    _, label = np.unique(recording * (number.max() + 1) + number, return_inverse=True)
    return label


def improvement(
    before: np.ndarray, after: np.ndarray, block: np.ndarray, rng: np.random.Generator
) -> Improvement:
    """How much smaller the residuals (nsample,) `after` are than `before`."""
    count = block.max() + 1
    old = np.bincount(block, before**2, count)
    new = np.bincount(block, after**2, count)
    drawn = rng.integers(0, count, (RESAMPLES, count))
    fractions = 1 - _ratio(new[drawn].sum(axis=1), old[drawn].sum(axis=1))
    low, high = np.quantile(fractions, (0.025, 0.975))  # statistics: a 95 % interval
    return Improvement(
        float(1 - _ratio(new.sum(), old.sum())),
        (float(low), float(high)),
        float(np.quantile(fractions, DECISION_LEVEL)),
    )


def _ratio(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Of root sums of squares; one where both are zero."""
    tiny = np.finfo(float).tiny
    return np.sqrt(np.maximum(after, tiny) / np.maximum(before, tiny))
