"""How many numbers a curve needs to explain what it explains."""

import numpy as np

from t2l.effects.law import SIGNED
from t2l.identify.prediction import Predictor
from t2l.propose.bases import penalty
from t2l.propose.decision import NEAR
from t2l.propose.dictionary import responses, weights_in
from t2l.propose.found import Search
from t2l.propose.ridge import LEAST, solve

PENALTIES = 10.0 ** np.arange(8, -9, -1)  # numerics: of a straight line, to one that is not felt


def freedom(found: Search, predictor: Predictor, fitted: np.ndarray, chosen: np.ndarray) -> float:
    """Effective parameters of the smoothest curve of the last law that leaves as little as its own.

    The effective number is the trace of the smoother (Eilers and Marx, 1996); as little is `NEAR`
    times. The simulation is taken as linear around the curve that was found.
    """
    effect = found.laws[-1]
    jacobian = _around(found, predictor)
    weights = found.state.u[weights_in(found.state.layout, effect)]
    target = found.residual + jacobian @ weights
    j, rows = jacobian[fitted], penalty(effect)
    normal, right = j.T @ j, j.T @ target[fitted]
    if not len(rows):
        return float(len(weights))
    limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
    size = np.trace(normal) / np.sum(rows**2)
    small = LEAST * np.diag(normal).max() * np.eye(len(normal))
    for factor in PENALTIES * size:
        bend = factor * rows.T @ rows
        smooth = solve(normal, right, bend, effect.law.kind not in SIGNED)
        left = target - jacobian @ smooth
        if np.sqrt(np.mean(left[chosen] ** 2)) <= limit:
            return float(np.trace(np.linalg.solve(normal + bend + small, normal)))
    return float(len(weights))


def _around(found: Search, predictor: Predictor) -> np.ndarray:
    """Responses (nsample, k) to the weights of the last law, at what was found."""
    effect, state = found.laws[-1], found.state
    (answer,) = responses(predictor, state.layout, state.u, [effect])
    return answer
