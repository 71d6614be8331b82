"""Rank correlation over cells, with an interval that resamples cells."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

# 50 of them lie beyond either end of a 95 % interval, which places it to a tenth of its width
RESAMPLES = 2000
# of fewer cells many resamples hold the same two or three, which correlate perfectly
FEWEST_CELLS = 8


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's ρ with a 95 % percentile-bootstrap interval; NaN where it is undetermined.

    Attributes:
        cells: that it is over, the unit of replication.
    """

    rho: float
    low: float
    high: float
    cells: int


def spearman(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Spearman's ρ of (..., n) numbers, ties sharing their mean rank.

    NaN where one side does not vary, or n is below 3.
    """
    x, y = (rankdata(side, axis=-1) for side in (x, y))
    x, y = (side - side.mean(axis=-1, keepdims=True) for side in (x, y))
    spread = np.sqrt((x**2).sum(axis=-1) * (y**2).sum(axis=-1))
    known = (spread > 0) & (x.shape[-1] >= 3)
    return np.divide((x * y).sum(axis=-1), spread, where=known, out=np.full(spread.shape, np.nan))


def rank_correlations(
    predictors: dict[str, np.ndarray], outcome: np.ndarray, rng: np.random.Generator
) -> tuple[dict[str, RankCorrelation], dict[str, tuple[float, float, float]]]:
    """ρ of each predictor with the outcome, and by how much the first one's is the stronger.

    All predictors see the same resamples, so that their difference has an interval of its own.

    Args:
        predictors: (n,) numbers each, one a cell.
        outcome: (n,).

    Returns:
        By predictor: its correlation; and for all but the first |ρ_first| − |ρ| with its interval.
    """
    n, names = len(outcome), list(predictors)
    values = [np.asarray(predictors[name], float) for name in names]
    outcome = np.asarray(outcome, float)
    rho = np.array([spearman(value, outcome) for value in values])
    drawn = np.full((RESAMPLES, len(names)), np.nan)
    if n >= FEWEST_CELLS:
        chosen = rng.integers(0, n, (RESAMPLES, n))
        drawn = np.stack([spearman(value[chosen], outcome[chosen]) for value in values], axis=1)
    ends = _interval(drawn)
    found = {
        name: RankCorrelation(float(rho[i]), *ends[i], cells=n) for i, name in enumerate(names)
    }
    stronger = np.abs(drawn[:, :1]) - np.abs(drawn)
    ends = _interval(stronger)
    return found, {
        name: (float(abs(rho[0]) - abs(rho[i])), *ends[i]) for i, name in enumerate(names) if i
    }


def _interval(drawn: np.ndarray) -> list[tuple[float, float]]:
    """95 % of each column, NaN where fewer than 95 % of the draws are numbers."""
    usual = np.isfinite(drawn).mean(axis=0) >= 0.95
    return [
        tuple(map(float, np.nanquantile(column, (0.025, 0.975)))) if fine else (np.nan, np.nan)
        for column, fine in zip(drawn.T, usual, strict=True)
    ]
