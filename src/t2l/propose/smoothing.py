"""How smooth each curve is, chosen again when all are there.

A law's penalty is chosen when it is taken, while what comes after it is still missing. Its curve
may bend for that, or be smoother than it should be.
"""

import numpy as np

from t2l.effects.law import SIGNED
from t2l.identify.prediction import Predictor
from t2l.propose.bases import penalty
from t2l.propose.dictionary import weights_in
from t2l.propose.found import Search, earns_its_place
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.partial_regression import PartialRegression
from t2l.propose.refit import State, columns, finish, off, refit, without
from t2l.propose.ridge import fit


def smooth_again(found: Search, samples: LearningSamples, draft: Predictor) -> None:
    """Choose the penalty of each curve beside the others, where that earns its place.

    No worse with smoother curves needs no proof.

    Args:
        draft: with coarser ticks, for all but the last steps of a fit.
    """
    state, fitted, chosen = found.state, samples.fitted, samples.chosen
    if not any(len(penalty(effect)) for effect in found.laws):
        return
    jacobian = columns(state, draft, np.ones(len(fitted), bool))
    laws = []
    for effect, factor in state.laws:
        rows, at = penalty(effect), weights_in(state.layout, effect)
        if len(rows):
            others = PartialRegression.at(without(state, [effect.name]), jacobian, fitted)
            answer = np.stack([jacobian[state.layout.slots[i].key] for i in at], axis=1)
            target = others.left_of(found.residual + answer @ state.u[at])
            beside, positive = others.left_of_responses(answer), effect.law.kind not in SIGNED
            factor = fit(beside, target, *others.masks(chosen), rows, positive).penalty
        laws.append((effect, factor))
    changed = State(state.layout, state.u.copy(), tuple(laws))
    shift = off(draft, state, found.residual)[fitted]
    finish([changed], refit([changed], draft, fitted, shift=shift), samples.predictor, fitted)
    (residual,), (error,) = samples.left_by([changed])
    pairs = zip(state.laws, laws, strict=True)
    smoother = all(before <= factor for (_, before), (_, factor) in pairs)
    if (smoother and error <= found.rmse_rad) or earns_its_place(found.residual, residual, samples):
        found.put(samples.predictor, changed, residual, error)
