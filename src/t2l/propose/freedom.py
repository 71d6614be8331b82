"""How many numbers curves need to explain what they explain."""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import SIGNED
from t2l.effects.learned import SplineTorque
from t2l.effects.term import Slot
from t2l.identify.prediction import Request
from t2l.propose.bases import penalty
from t2l.propose.decision import NEAR
from t2l.propose.dictionary import responses, weights_in
from t2l.propose.found import Search
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, sizes
from t2l.propose.ridge import least_ridge, solve

# numerics: of a straight line, to one that is not felt, four in each power of ten
PENALTIES = 10.0 ** np.linspace(8, -8, 65)
STEP = 1e-2  # numerics: of what makes a difference
ALIKE = 1e-3  # numerics: of the largest singular value; differences are off by 1e-4
DIGITS = 2  # numerics: of an effective number


def independent(state: State, slots: Sequence[Slot], samples: LearningSamples) -> int:
    """How many of some numbers of a model the recordings can tell from each other."""
    at = [i for i, slot in enumerate(state.layout.slots) if slot in slots]
    step = STEP * sizes(state)[at, None] * np.eye(len(state.u))[at]
    # central differences: the curvature of one would look like another number
    points = np.clip([state.u + step, state.u - step], state.layout.lower, state.layout.upper)
    requests = [Request(state.layout, each) for each in points]
    more, less = (q[:, samples.fitted] for q in samples.predictor.predict(requests))
    told = np.nan_to_num(more - less)  # a simulation that ran away tells nothing
    size = np.linalg.norm(told, axis=1, keepdims=True)
    return int(np.linalg.matrix_rank(told / np.where(size > 0, size, 1.0), ALIKE))


def freedom(found: Search, samples: LearningSamples) -> float:
    """Effective parameters of the smoothest curves that leave as little as those that were found.

    The effective number is the trace of the smoother (Eilers and Marx, 1996); as little is `NEAR`
    times, of each curve beside the others. The simulation is taken as linear around them.
    """
    answers = responses(samples.predictor, found.state.layout, found.state.u, found.laws)
    each = zip(found.laws, answers, strict=True)
    # the trace of a straight line is a little less than two
    return round(sum(_freedom(found, *one, samples) for one in each), DIGITS)


def _freedom(
    found: Search, effect: SplineTorque, jacobian: np.ndarray, samples: LearningSamples
) -> float:
    weights = found.state.u[weights_in(found.state.layout, effect)]
    target = found.residual + jacobian @ weights
    j, rows = jacobian[samples.fitted], penalty(effect)
    normal, right = j.T @ j, j.T @ target[samples.fitted]
    if not len(rows):
        return float(len(weights))
    limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
    size = np.trace(normal) / np.sum(rows**2)
    small = least_ridge(normal)
    for factor in PENALTIES * size:
        bend = factor * rows.T @ rows
        smooth = solve(normal, right, bend, effect.law.kind not in SIGNED)
        left = target - jacobian @ smooth
        if np.sqrt(np.mean(left[samples.chosen] ** 2)) <= limit:
            return float(np.trace(np.linalg.solve(normal + bend + small, normal)))
    return float(len(weights))
