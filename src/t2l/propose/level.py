"""Less in place of curves that were taken, or bent, only because something else was missing."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.effects.law import ALLOWED, Law
from t2l.effects.learned import SplineTorque
from t2l.identify.prediction import Predictor
from t2l.propose.bases import constant
from t2l.propose.dictionary import weights_in
from t2l.propose.found import Search, left_by
from t2l.propose.refit import State, finish, off, refit, with_law, without


def simplify(
    found: Search,
    curves: Sequence[SplineTorque],
    limit_rad: float,
    predictor: Predictor,
    draft: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
) -> None:
    """Take `curves` away in turn, or put constants in their place, where that costs nothing.

    That is where the choosing samples are left with `limit_rad` at most.

    Args:
        draft: with coarser ticks, for all but the last steps of a fit.
        fitted, chosen: (nsample,) bool, samples to fit and samples to choose by.
    """
    for curve in curves:
        trials, law = [without(found.state, [curve.name])], level_of(found.state, curve)
        if law is not None:
            trials.append(levelled(found.state, curve, law, predictor.joints))
        shift = off(draft, found.state, found.residual)[fitted]
        finish(trials, refit(trials, draft, fitted, shift=shift), predictor, fitted)
        for trial, *left in zip(trials, *left_by(trials, predictor, chosen), strict=True):
            if left[-1] <= limit_rad:
                found.put(predictor, trial, *left)
                break


def level_of(state: State, curve: SplineTorque) -> Law | None:
    """The constant that could take the place of a curve; None if there is none, or it is there."""
    law = replace(curve.law, follows="constant", of=curve.law.joint)
    new = law not in {other.law for other, _ in state.laws}
    return law if new and "constant" in ALLOWED[law.kind] else None


def levelled(state: State, curve: SplineTorque, law: Law, joints: tuple[str, ...]) -> State:
    """The state with the constant `law` in place of `curve`, at its mean; the last of the laws."""
    mean = np.mean(curve.basis @ state.u[weights_in(state.layout, curve)], keepdims=True)
    level = constant(law, curve.parameters[0].size)
    # one weight has no penalty
    return with_law(without(state, [curve.name]), level, mean, 1.0, joints)
