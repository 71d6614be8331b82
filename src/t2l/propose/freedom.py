"""How many numbers curves need to explain what they explain."""

import numpy as np

from t2l.effects.law import SIGNED
from t2l.effects.learned import SplineTorque
from t2l.identify.prediction import Predictor
from t2l.propose.bases import penalty
from t2l.propose.decision import NEAR
from t2l.propose.dictionary import responses, weights_in
from t2l.propose.found import Search
from t2l.propose.ridge import LEAST, solve

# numerics: of a straight line, to one that is not felt, four in each power of ten
PENALTIES = 10.0 ** np.linspace(8, -8, 65)


def freedom(found: Search, predictor: Predictor, fitted: np.ndarray, chosen: np.ndarray) -> float:
    """Effective parameters of the smoothest curves that leave as little as those that were found.

    The effective number is the trace of the smoother (Eilers and Marx, 1996); as little is `NEAR`
    times, of each curve beside the others. The simulation is taken as linear around them.
    """
    answers = responses(predictor, found.state.layout, found.state.u, found.laws)
    each = zip(found.laws, answers, strict=True)
    return sum(_freedom(found, effect, answer, fitted, chosen) for effect, answer in each)


def _freedom(
    found: Search,
    effect: SplineTorque,
    jacobian: np.ndarray,
    fitted: np.ndarray,
    chosen: np.ndarray,
) -> float:
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
