"""How sure a learned curve is: a bootstrap over blocks of time."""

from typing import Protocol

import numpy as np

from t2l.effects.spline_torque import SplineTorque, weights_of
from t2l.effects.term import Layout
from t2l.identify.block_bootstrap import blocks
from t2l.identify.samples import Samples

RESAMPLES = 500  # statistics: the ends of a 95 % interval each have a dozen beyond them
SEED = 0  # statistics: of the bootstrap
LEAST = 1e-10  # numerics: of the normal equations, what is added to them
LEVEL = 0.95  # statistics: the customary one


class Fitted(Protocol):
    """What a band is made of: parameters of a layout with residuals and derivatives of samples."""

    layout: Layout
    u: np.ndarray
    free: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray


def band(
    fit: Fitted,
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
        rows: (m, n) of the layout's prior, in rad.
        mask: (nsample,) bool, the samples that were fitted.
        anchor: (n, n) as `t2l.propose.shared_constants.anchoring`, of the curves that are drawn.
    """
    index = weights_of(fit.layout, effect)
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
    shape = effect.shape
    rest = np.zeros(len(fit.u))
    rest[free] = least
    drawn = shape @ anchor[index]
    curve = drawn @ fit.u
    low, high = np.quantile(spread @ drawn.T, ((1 - LEVEL) / 2, (1 + LEVEL) / 2), axis=0)
    bent = np.abs(drawn @ bias) + np.abs(drawn @ rest)
    return np.stack([curve + low - bent, curve + high + bent])
