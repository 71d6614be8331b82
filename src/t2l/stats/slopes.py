"""How a cell's number changes per doubling of a gain, with cells as the unit of replication."""

import warnings
from dataclasses import dataclass
from math import nan

import numpy as np
import statsmodels.api as sm
from numpy.typing import ArrayLike
from statsmodels.genmod.families import Binomial
from statsmodels.tools.sm_exceptions import PerfectSeparationWarning

COEFFICIENTS = 3


@dataclass(frozen=True)
class Slopes:
    """Per doubling of Kp and of Kd, with standard errors; NaN where the data determine nothing.

    Attributes:
        freedom: degrees of freedom that the errors rest on.
    """

    kp: float = nan
    kd: float = nan
    kp_error: float = nan
    kd_error: float = nan
    freedom: int = 0


def share_slopes(kp: ArrayLike, kd: ArrayLike, successes: ArrayLike, trials: ArrayLike) -> Slopes:
    """Log odds of success of cells, an over-dispersed binomial model.

    The coefficients are those of a logistic regression over rollouts. Their errors are scaled by
    Pearson's χ² over its degrees of freedom (McCullagh and Nelder 1989, section 4.5): cells that
    scatter more than their rollouts explain widen them. They are never narrower than binomial.

    Args:
        kp, kd, successes, trials: (n,), one row a cell.
    """
    design = _design(kp, kd)
    won, all_ = np.asarray(successes, float), np.asarray(trials, float)
    freedom = len(design) - COEFFICIENTS
    if freedom < 1 or np.linalg.matrix_rank(design) < COEFFICIENTS or won.sum() in (0, all_.sum()):
        return Slopes()
    with warnings.catch_warnings():
        warnings.simplefilter("error", PerfectSeparationWarning)
        try:
            fit = sm.GLM(np.column_stack([won, all_ - won]), design, family=Binomial()).fit()
        except PerfectSeparationWarning:
            return Slopes()
    # without a maximum the errors explode long before the iterations stop
    if not fit.converged or not np.all(fit.bse < 1e3):
        return Slopes()
    scale = np.sqrt(max(1.0, fit.pearson_chi2 / freedom))
    return Slopes(*map(float, fit.params[1:]), *map(float, scale * fit.bse[1:]), freedom)


def log_slopes(kp: ArrayLike, kd: ArrayLike, values: ArrayLike) -> Slopes:
    """Of ln values, ordinary least squares.

    Args:
        kp, kd, values: (n,), one row a cell, values positive.
    """
    design = _design(kp, kd)
    freedom = len(design) - COEFFICIENTS
    if freedom < 1 or np.linalg.matrix_rank(design) < COEFFICIENTS:
        return Slopes()
    fit = sm.OLS(np.log(np.asarray(values, float)), design).fit()
    return Slopes(*map(float, fit.params[1:]), *map(float, fit.bse[1:]), freedom)


def _design(kp: ArrayLike, kd: ArrayLike) -> np.ndarray:
    gains = np.log2(np.column_stack([np.asarray(kp, float), np.asarray(kd, float)]))
    return np.column_stack([np.ones(len(gains)), gains])
