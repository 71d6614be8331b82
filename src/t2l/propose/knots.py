"""More knots for the law that was taken last, where they earn their place."""

from collections.abc import Callable, Mapping

import numpy as np

from t2l.diagnose.settings import SCREENED
from t2l.effects.spline_torque import SplineTorque
from t2l.identify.prediction import Predictor
from t2l.propose.bases import may_be_finer, penalty
from t2l.propose.dictionary import responses, weights_in
from t2l.propose.found import Search, earns_its_place
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import finish, refit, with_law, without
from t2l.propose.ridge import fit
from t2l.propose.split import few

Finer = Callable[[int], SplineTorque]  # a law with so many times its knots


def refine(
    found: Search,
    finer: Finer,
    samples: LearningSamples,
    draft: Predictor,
    given: Mapping[tuple, np.ndarray],
) -> None:
    """Give the law that was taken last knots until more do not earn their place.

    Args:
        draft: with coarser ticks, for all but the last steps of a fit.
        given: derivatives by what stands beside the law, see `t2l.propose.refit.columns`.
    """
    predictor, fitted, chosen = samples.predictor, samples.fitted, samples.chosen
    times = 2
    while found.left_more_than_noise and may_be_finer(found.laws[-1]):
        coarse, effect = found.laws[-1], finer(times)
        curve = coarse.basis @ found.state.u[weights_in(found.state.layout, coarse)]
        bare = without(found.state, [coarse.name])
        weights = np.linalg.lstsq(effect.basis, curve, rcond=None)[0]
        begun = with_law(bare, effect, weights, 1.0, predictor.joints)
        screen, at = few(draft, max(SCREENED))
        (answer,) = responses(screen, begun.layout, begun.u, [effect])
        target = found.residual[at] + answer @ weights
        guess = fit(answer, target, fitted[at], chosen[at], penalty(effect))
        grown = with_law(bare, effect, guess.weights, guess.penalty, predictor.joints)
        finish([grown], refit([grown], draft, fitted, 0, given=given), predictor, fitted)
        (residual,), (error,) = samples.left_by([grown])
        if not earns_its_place(found.residual, residual, samples):
            break
        found.put(predictor, grown, residual, error)
        times *= 2
