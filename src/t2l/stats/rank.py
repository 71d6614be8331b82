"""Rank correlation over cells, with an interval that resamples cells."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

from t2l.stats.bootstrap import bootstrap_interval

# of fewer cells many resamples hold the same two or three, which correlate perfectly
FEWEST_CELLS = 8
DIGITS = 12  # numerics: of 15 to 16 that a number has, so that three operations leave none wrong


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


def without_rounding(values: np.ndarray) -> np.ndarray:
    """(..., n) numbers of which those are equal that differ by rounding errors: 0.1 + 0.2 and 0.3.

    Ranks would tell them apart. Errors are proportional to the largest number along the last axis.
    """
    values = np.asarray(values, float)
    if not values.shape[-1]:
        return values
    size = np.abs(values).max(axis=-1, keepdims=True)
    size = np.where((size > 0) & np.isfinite(size), size, 1.0)
    return np.round(values / size, DIGITS)


def spearman(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Spearman's ρ of (..., n) numbers, ties sharing their mean rank.

    NaN where one side does not vary, or n is below 3.
    """
    x, y = (rankdata(without_rounding(side), axis=-1) for side in (x, y))
    if not x.shape[-1]:
        return np.full(x.shape[:-1], np.nan)
    x, y = (side - side.mean(axis=-1, keepdims=True) for side in (x, y))
    spread = np.sqrt((x**2).sum(axis=-1) * (y**2).sum(axis=-1))
    known = (spread > 0) & (x.shape[-1] >= 3)
    return np.divide((x * y).sum(axis=-1), spread, where=known, out=np.full(spread.shape, np.nan))


def rank_correlations(
    predictors: dict[str, np.ndarray], outcome: np.ndarray
) -> tuple[dict[str, RankCorrelation], dict[str, tuple[float, float, float]]]:
    """ρ of each predictor with the outcome, and by how much the first one's is the stronger.

    All predictors see the same resamples, so that their difference has an interval of its own.

    Args:
        predictors: (n,) numbers each, one a cell.
        outcome: (n,).

    Returns:
        By predictor: its correlation; and for all but the first |ρ_first| − |ρ| with its interval.
    """
    first, *others = predictors
    found = {
        name: RankCorrelation(*_with_interval(spearman, values, outcome), cells=len(outcome))
        for name, values in predictors.items()
    }
    return found, {
        name: _with_interval(_stronger, predictors[first], predictors[name], outcome)
        for name in others
    }


def _stronger(one: np.ndarray, other: np.ndarray, outcome: np.ndarray) -> np.ndarray:
    return np.abs(spearman(one, outcome)) - np.abs(spearman(other, outcome))


def _with_interval(statistic: Callable, *columns: np.ndarray) -> tuple[float, float, float]:
    arrays = [np.asarray(column, float) for column in columns]
    enough = len(arrays[0]) >= FEWEST_CELLS
    ends = bootstrap_interval(statistic, *arrays, paired=True) if enough else (np.nan, np.nan)
    return (float(statistic(*arrays)), *ends)
