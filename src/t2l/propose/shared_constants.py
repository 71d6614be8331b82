"""Constants that laws share: f(q) + c and g(q̇) − c are one model, whatever c is.

So smooth terms of additive models are centred (Hastie and Tibshirani, Generalized additive models,
1986). Here a curve passes through zero where its variable is zero, as friction does at rest, and
one of those that share a constant keeps it.
"""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import MOTOR, TENDON, TORQUE, Law
from t2l.effects.spline_torque import SplineTorque, weights_of
from t2l.effects.term import Layout

SAME = 1e-3  # numerics: of the responses to constants: less is no difference
SHARING = (TORQUE, TENDON, MOTOR)  # kinds whose constants may be below zero, and add up
AT_ZERO = ("velocity", "commanded torque", "load")  # where these are zero a torque should be


def anchoring(layout: Layout, laws: Sequence[SplineTorque], jacobian: np.ndarray) -> np.ndarray:
    """(n, n): times parameters u it moves constants between laws, and the simulation stays.

    Args:
        laws: in the order in which they were taken.
        jacobian: (nsample, n) of the positions.
    """
    count = jacobian.shape[1]
    laws = [law for law in laws if _has_a_constant(law)]
    ones = np.zeros((count, len(laws)))
    for k, law in enumerate(laws):
        ones[weights_of(layout, law), k] = 1.0
    untold = _untold(jacobian @ ones)
    if not untold.shape[1]:
        return np.eye(count)
    kept: list[int] = []
    for k in sorted(range(len(laws)), key=lambda k: _order(laws[k].law, k)):
        if np.linalg.matrix_rank(untold[[*kept, k]], tol=SAME) > len(kept):
            kept.append(k)
    values = np.zeros((len(kept), count))
    for row, k in enumerate(kept):
        values[row, weights_of(layout, laws[k])] = _at_zero(laws[k])
    return np.eye(count) - ones @ untold @ np.linalg.pinv(untold[kept]) @ values


def _has_a_constant(effect: SplineTorque) -> bool:
    return effect.law.kind in SHARING and np.allclose(effect.basis.sum(axis=1), 1.0)


def _untold(responses: np.ndarray) -> np.ndarray:
    """(k, d) orthonormal: what constants of k laws may change together and nothing tells it.

    Args:
        responses: (nsample, k) to a constant of each.
    """
    size = np.linalg.norm(responses, axis=0)
    if not (size > 0).all() or len(size) < 2:
        return np.zeros((len(size), 0))
    _, told, directions = np.linalg.svd(responses / size, full_matrices=False)
    return np.linalg.qr((directions[told < SAME * told.max()] / size).T)[0]


def _order(law: Law, taken: int) -> tuple:
    """Which passes through zero first: a law that should, and then one that was taken later."""
    return law.follows == "constant", law.follows not in AT_ZERO, -taken


def _at_zero(effect: SplineTorque) -> np.ndarray:
    """(k,) that makes the torque of weights, where the variable is zero or nearest to it."""
    return np.array([np.interp(0.0, effect.grid, one) for one in effect.basis.T])
