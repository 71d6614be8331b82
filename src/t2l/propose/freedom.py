"""How many numbers curves need to explain what they explain."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from t2l.effects.law import PHASE, SIGNED, TENDON, Law
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Slot
from t2l.identify.prediction import Request
from t2l.propose.bases import penalty
from t2l.propose.decision import NEAR
from t2l.propose.dictionary import responses, weights_in
from t2l.propose.expression import Formula
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


def freedom(
    found: Search,
    samples: LearningSamples,
    formulas: Mapping[Law, Formula] = MappingProxyType({}),
) -> float:
    """Effective parameters of the smoothest curves that leave as little as those that were found.

    The effective number is the trace of the smoother of all curves together (Eilers and Marx,
    1996): what two of them share, as a constant, counts once. As little is `NEAR` times, of each
    curve beside the others. The simulation is taken as linear around them.

    Args:
        formulas: of laws that are counted by their constants.
    """
    from scipy.linalg import block_diag

    answers = responses(samples.predictor, found.state.layout, found.state.u, found.laws)
    columns, bends, others = [], [], 0
    for effect, answer in zip(found.laws, answers, strict=True):
        formula = formulas.get(effect.law)
        # a ratio, and a period that no formula holds
        others += effect.law.kind == TENDON
        if formula:
            # what a change of each constant changes of the weights
            moved = np.linalg.lstsq(effect.basis, _slopes(formula, effect.grid), rcond=None)[0]
            columns.append(answer[samples.fitted] @ moved)
            bends.append(np.zeros((0, moved.shape[1])))
        else:
            columns.append(answer[samples.fitted])
            bends.append(_smoothest(found, effect, answer, samples))
            others += effect.law.follows == PHASE
    jacobian = np.concatenate(columns, axis=1)
    size = np.linalg.norm(jacobian, axis=0)
    size = np.where(size > 0, size, 1.0)
    normal = (jacobian / size).T @ (jacobian / size)
    bend = block_diag(*(b.T @ b for b in bends)) / np.outer(size, size)
    # the trace of a straight line is a little less than two
    whole = np.trace(np.linalg.solve(normal + bend + least_ridge(normal), normal))
    return round(float(whole) + others, DIGITS)


def _slopes(formula: Formula, x: np.ndarray) -> np.ndarray:
    """(g, c) by each constant of a formula, at x (g,)."""
    columns = []
    for name, value in formula.values.items():
        step = STEP * max(abs(value), STEP)
        more, less = (formula(x, {**formula.values, name: value + s}) for s in (step, -step))
        columns.append((more - less) / (2 * step))
    return np.stack(columns, axis=1)


def _smoothest(
    found: Search, effect: SplineTorque, jacobian: np.ndarray, samples: LearningSamples
) -> np.ndarray:
    """(m, k) of the largest penalty with which a curve leaves as little."""
    weights = found.state.u[weights_in(found.state.layout, effect)]
    target = found.residual + jacobian @ weights
    j, rows = jacobian[samples.fitted], penalty(effect)
    normal, right = j.T @ j, j.T @ target[samples.fitted]
    if not len(rows):
        return rows
    limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
    size = np.trace(normal) / np.sum(rows**2)
    for factor in PENALTIES * size:
        bend = factor * rows.T @ rows
        smooth = solve(normal, right, bend, effect.law.kind not in SIGNED)
        left = target - jacobian @ smooth
        if np.sqrt(np.mean(left[samples.chosen] ** 2)) <= limit:
            return np.sqrt(factor) * rows
    return 0 * rows
