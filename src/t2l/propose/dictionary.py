"""What the simulation answers to a small torque of each basis function, at the present model."""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import FRICTION
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import ACROSS_KINKS
from t2l.identify.prediction import Predictor, Request

STEP = 1e-3  # numerics: of a torque that makes a difference
STEP_OF_FRICTION = ACROSS_KINKS  # likewise: the solver of contacts sees no smaller one


def term_of(effect: SplineTorque, joints: tuple[str, ...]) -> Term:
    """A law's effect where it acts."""
    return Term(effect, (joints.index(effect.law.joint),))


def joined(layout: Layout, u: np.ndarray, terms: Sequence[Term]) -> tuple[Layout, np.ndarray]:
    """A layout with more terms, their parameters zero."""
    whole = Layout([*layout.terms, *terms])
    return whole, moved(layout, u, whole)


def moved(layout: Layout, u: np.ndarray, to: Layout) -> np.ndarray:
    """The same values in another layout; zero for what `layout` has not."""
    known = dict(zip((slot.key for slot in layout.slots), u, strict=True))
    return np.array([known.get(slot.key, 0.0) for slot in to.slots])


def weights_in(layout: Layout, effect: SplineTorque) -> np.ndarray:
    """Indices of a law's weights."""
    return _slots_of(layout, effect)[: effect.basis.shape[1]]


def rest_in(layout: Layout, effect: SplineTorque) -> np.ndarray:
    """Indices of a law's parameters that are no weights."""
    return _slots_of(layout, effect)[effect.basis.shape[1] :]


def _slots_of(layout: Layout, effect: SplineTorque) -> np.ndarray:
    slots = enumerate(layout.slots)
    return np.array([i for i, s in slots if s.term.effect.name == effect.name], int)


def responses(
    predictor: Predictor, layout: Layout, u: np.ndarray, effects: Sequence[SplineTorque]
) -> list[np.ndarray]:
    """Change of position (nsample, k) per unit of each weight, rad/(N·m), for each law.

    Of a law that is not there yet and has atoms: by each atom, (nsample, a) rad.
    """
    requests, steps = [Request(layout, u[None])], []
    for effect in effects:
        whole, start = layout, u
        new = not len(weights_in(layout, effect))
        if new:
            whole, start = joined(layout, u, [term_of(effect, predictor.joints)])
        index = weights_in(whole, effect)
        by_atoms = new and effect.atoms is not None
        moves = effect.atoms if by_atoms else step_of(effect) * np.eye(len(index))
        points = np.repeat(start[None], len(moves), axis=0)
        points[:, index] += moves
        requests.append(Request(whole, points))
        steps.append(1.0 if by_atoms else step_of(effect))
    base, *moved_to = predictor.predict(requests)
    return [np.nan_to_num((q - base[0]) / step).T for q, step in zip(moved_to, steps, strict=True)]


def step_of(effect: SplineTorque) -> float:
    """N·m by which a weight moves."""
    part = STEP_OF_FRICTION if effect.law.kind == FRICTION else STEP
    return part * effect.parameters[0].size
