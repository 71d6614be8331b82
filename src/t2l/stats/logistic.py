"""How the odds of success change with the gains."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_linear_model import GLM
from statsmodels.tools.sm_exceptions import PerfectSeparationWarning


@dataclass(frozen=True)
class LogisticFit:
    """logit P(success) = intercept + kp · log2 Kp + kd · log2 Kd, with standard errors.

    NaN where the data determine nothing: all successes, all failures, one gain only, or a perfect
    separation.
    """

    intercept: float
    kp: float
    kd: float
    kp_error: float
    kd_error: float


UNDETERMINED = LogisticFit(*[float("nan")] * 5)


def logistic_regression(kp: ArrayLike, kd: ArrayLike, success: ArrayLike) -> LogisticFit:
    """Binomial logistic regression by maximum likelihood, one row per rollout.

    Args:
        kp, kd: (n,) gains of each rollout.
        success: (n,) bool.
    """
    regressors = np.log2(np.column_stack([kp, kd]))
    success = np.asarray(success, dtype=float)
    design = np.column_stack([np.ones(len(regressors)), regressors])
    if success.min() == success.max() or np.linalg.matrix_rank(design) < design.shape[1]:
        return UNDETERMINED
    with warnings.catch_warnings():
        warnings.simplefilter("error", PerfectSeparationWarning)
        try:
            fit = GLM(success, design, family=Binomial()).fit()
        except PerfectSeparationWarning:
            return UNDETERMINED
    # without a maximum the errors explode long before the iterations stop
    if not fit.converged or not np.all(fit.bse < 1e3):
        return UNDETERMINED
    return LogisticFit(*fit.params, *fit.bse[1:])
