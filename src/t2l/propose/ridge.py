"""The curve that fits best: a penalised linear fit, whose penalty other data choose."""

from dataclasses import dataclass

import numpy as np

from t2l.identify.levels import NOTHING

# numerics: of the penalty, relative to the size of the responses; the least hardly bends a curve,
# the most leaves a straight line
PENALTIES = 10.0 ** np.arange(-7, 3)
ALIKE = 1 + NOTHING  # derived: times the least squared residual where a penalty is chosen
LEAST = 1e-10  # numerics: of the responses, what is added to them
SMALLEST = 1e-200  # numerics: whose inverse is finite, where no data touch any weight


@dataclass(frozen=True)
class Fit:
    """Weights (k,), the penalty's factor, and the mean squared residual on both sets, rad²."""

    weights: np.ndarray
    penalty: float
    fitted: float
    chosen: float


def fit(
    responses: np.ndarray,
    residual: np.ndarray,
    fitted: np.ndarray,
    chosen: np.ndarray,
    rows: np.ndarray,
    positive: bool = False,
) -> Fit:
    """Weights that make `responses` (n, k) times them near `residual` (n,).

    Args:
        fitted, chosen: (n,) bool, samples that are fitted and samples that choose the penalty.
        rows: (m, k) of the penalty.
        positive: whether weights may not be negative.
    """
    j, r = responses[fitted], residual[fitted]
    normal, right = j.T @ j, j.T @ r
    factors = PENALTIES if len(rows) else PENALTIES[:1]
    size = np.trace(normal) / max(np.sum(rows**2), 1e-300)
    tried = []
    for factor in factors * size:
        weights = solve(normal, right, factor * rows.T @ rows, positive)
        left = residual - responses @ weights
        found = Fit(
            weights, float(factor), float(np.mean(left[fitted] ** 2)),
            float(np.mean(left[chosen] ** 2)),
        )  # fmt: skip
        tried.append(found)
    # of penalties that do alike the largest, which makes the smoothest curve
    limit = ALIKE * min(one.chosen for one in tried)
    return [one for one in tried if one.chosen <= limit][-1]


def solve(
    normal: np.ndarray, right: np.ndarray, penalties: np.ndarray, positive: bool
) -> np.ndarray:
    """Weights (k,) of the normal equations with a penalty (k, k)."""
    whole = normal + penalties + least_ridge(normal)
    if not positive:
        return np.linalg.solve(whole, right)
    from scipy.optimize import nnls

    root = np.linalg.cholesky(whole)
    return nnls(root.T, np.linalg.solve(root, right))[0]


def least_ridge(normal: np.ndarray) -> np.ndarray:
    """(k, k) to add to normal equations, which keeps weights that no data touch at zero."""
    return max(LEAST * np.diag(normal).max(initial=0.0), SMALLEST) * np.eye(len(normal))
