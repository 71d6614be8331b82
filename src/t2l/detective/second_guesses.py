"""Other values of a set's own terms, read off the torque that is missing without them.

The first guess of a ripple was read off while other effects were missing too, so it may have led to
the wrong minimum. Beside the rest of the set the same reading is clearer.
"""

from collections.abc import Sequence

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.candidates import encoded
from t2l.detective.fitted_set import FittedSet, Start, sizes
from t2l.detective.pruning import without_one
from t2l.detective.starting_points import read_off
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.optimiser import minimise

ALONE = 2  # numerics: iterations of the rest, beside which a guess is read


def second_guesses(whole: FittedSet, along: AlongMotion, folds: np.ndarray) -> list[FittedSet]:
    """The same set fitted along the motion, each from another value of a term on a joint."""
    begun: list[Start] = []
    for less in without_one(whole):
        term, joint = _gone(whole.layout, less.layout)
        if type(term.effect).read_off is not Effect.read_off:
            begun += _read(whole, term, joint, _fitted(less, along), along)
    return fit_along(begun, along, folds)


def _gone(whole: Layout, less: Layout) -> tuple[Term, int]:
    """The term of which the second lacks a joint, and that."""
    kept = {term.effect.name: set(term.joints) for term in less.terms}
    for term in whole.terms:
        lost = set(term.joints) - kept.get(term.effect.name, set())
        if lost:
            return term, min(lost)
    raise ValueError("nothing is gone")


def _fitted(start: Start, along: AlongMotion) -> tuple[Layout, np.ndarray]:
    """A set when it is fitted."""
    fit = LeastSquares(
        start.layout, start.u.copy(), sizes(start), given=dict(start.columns), secant=True,
        noise=along.noise_rad,
    )  # fmt: skip
    minimise([fit], along, ALONE)
    return fit.layout, fit.u


def _read(
    whole: FittedSet,
    term: Term,
    joint: int,
    rest: tuple[Layout, np.ndarray],
    along: AlongMotion,
) -> Sequence[Start]:
    """Starts with what is read off beside the rest in place of the values on a joint."""
    read = read_off(along.predictor, along.sections, along.mask, along.base, rest, [term.effect])
    guesses = read[term.effect.name]
    layout = whole.layout
    mine = {
        i: slot for i, slot in enumerate(layout.slots)
        if slot.term is term and slot.joint in (joint, None)
    }  # fmt: skip
    moved = {slot.key for slot in mine.values()}
    columns = {key: column for key, column in whole.columns.items() if key not in moved}
    starts = []
    for guess in guesses:
        u, said = whole.u.copy(), encoded(guess)
        for i, slot in mine.items():
            u[i] = said(slot)
        starts.append(Start(layout, np.clip(u, layout.lower, layout.upper), columns))
    return starts
