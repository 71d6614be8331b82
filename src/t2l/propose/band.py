"""How sure a learned curve is: a bootstrap over blocks of time."""

import numpy as np

from t2l.effects.law import HYSTERESIS
from t2l.effects.spline_torque import SplineTorque
from t2l.identify.block_bootstrap import blocks
from t2l.identify.least_squares import LeastSquares
from t2l.identify.samples import Samples
from t2l.propose.bases import points
from t2l.propose.dictionary import weights_in
from t2l.propose.ridge import LEAST

RESAMPLES = 500  # statistics: the ends of a 95 % interval each have a dozen beyond them
SEED = 0  # statistics: of the bootstrap
LEVEL = 0.95  # statistics: the customary one


def band(
    fit: LeastSquares,
    effect: SplineTorque,
    rows: np.ndarray,
    samples: Samples,
    mask: np.ndarray,
    anchor: np.ndarray,
) -> np.ndarray:
    """(2, n) N·m: the 95 % interval of the curve at the points of its table.

    Whole blocks of time are drawn again, and all parameters are fitted to them by the last
    derivatives: a curve is as unsure as the rest that is fitted with it. The penalty makes curves
    too straight; how much is estimated by fitting the fitted curve once more, and added.

    Args:
        fit: the last one, with the residuals of samples and then of penalties.
        rows: (m, n) of the penalties, as `t2l.propose.refit.State.rows`.
        mask: (nsample,) bool, the samples that were fitted.
        anchor: (n, n) as `t2l.propose.shared_constants.anchoring`, of the curves that are drawn.
    """
    index = weights_in(fit.layout, effect)
    free = fit.free & (np.abs(fit.jacobian).max(axis=0) > 0)
    jacobian = fit.jacobian[: mask.sum(), free]
    # what the linear model asks of the parameters: measured less predicted, plus what they give
    residual = -fit.residual[: mask.sum()]
    penalties = rows[:, free].T @ rows[:, free]
    block = blocks(samples.recording[mask], samples.time[mask])
    count = block.max() + 1
    normals = np.zeros((count, free.sum(), free.sum()))
    rights = np.zeros((count, free.sum()))
    for b in range(count):
        part = jacobian[block == b]
        normals[b], rights[b] = part.T @ part, part.T @ residual[block == b]
    draws = np.random.default_rng(SEED).multinomial(count, np.full(count, 1 / count), RESAMPLES)
    weights = np.empty((RESAMPLES, free.sum()))
    u = fit.u[free]
    whole = normals.sum(axis=0)
    small = LEAST * (np.diag(whole).max() + 1e-300) * np.eye(len(whole))
    # the fit may end a little before the least: draws are compared with where all blocks lead,
    # and what is left to there counts as unsure
    least = np.linalg.solve(whole + penalties + small, rights.sum(axis=0) - penalties @ u)
    for k, times in enumerate(draws):
        normal = np.tensordot(times, normals, 1)
        change = np.linalg.solve(normal + penalties + small, times @ rights - penalties @ u)
        weights[k] = change - least
    spread = np.zeros((RESAMPLES, len(fit.u)))
    spread[:, free] = weights
    bias = np.zeros(len(fit.u))
    bias[free] = np.linalg.solve(whole + penalties + small, penalties @ u)
    shape = _shape(effect)
    rest = np.zeros(len(fit.u))
    rest[free] = least
    drawn = shape @ anchor[index]
    curve = drawn @ fit.u
    low, high = np.quantile(spread @ drawn.T, ((1 - LEVEL) / 2, (1 + LEVEL) / 2), axis=0)
    bent = np.abs(drawn @ bias) + np.abs(drawn @ rest)
    return np.stack([curve + low - bent, curve + high + bent])


def _shape(effect: SplineTorque) -> np.ndarray:
    """(n, k) that makes the values of a table of weights, as `t2l.propose.bases.tabulated`."""
    if effect.law.kind == HYSTERESIS:
        at = np.concatenate([[0.0], effect.grid])
        return -np.minimum(at[:, None], effect.grid) / effect.grid
    if len(effect.grid) == 2:
        return effect.basis
    return effect.basis[points(effect)]
