"""Names and bends that a model with laws can do without."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from t2l.identify.fitting import REFINEMENTS
from t2l.identify.prediction import Predictor
from t2l.propose.decision import NEAR
from t2l.propose.found import Search
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, coarser, finish, off, refit, without
from t2l.propose.simplify import simplify


def eliminate(
    found: Search, adopted: Sequence[str], samples: LearningSamples
) -> tuple[Search, list[str]]:
    """`found` without the names whose loss costs nothing, and their list.

    Where a name goes, a curve may have bent only to undo what it did. So constants take the place
    of curves where that costs nothing.
    """
    limit = NEAR * max(found.rmse_rad, found.noise_floor_rad)
    draft = coarser(samples.predictor, found.state)
    shift = off(draft, found.state, found.residual)[samples.fitted]
    dropped: list[str] = []
    while left := [name for name in adopted if name not in dropped]:
        trials = [without(found.state, [name]) for name in left]
        errors = _refitted(trials, draft, samples, shift)
        best = int(np.argmin(errors))
        if not errors[best] <= limit:
            break
        found = replace(found, state=trials[best], rmse_rad=errors[best])
        dropped.append(left[best])
    if dropped:
        (residual,), _ = samples.left_by([found.state])
        found = replace(found, residual=residual)
        simplify(found, limit, samples, draft)
    return found, dropped


def _refitted(
    trials: list[State], draft: Predictor, samples: LearningSamples, shift: np.ndarray
) -> list[float]:
    """RMS errors in rad of states that are fitted anew."""
    fits = refit(trials, draft, samples.fitted, REFINEMENTS, shift)
    finish(trials, fits, samples.predictor, samples.fitted)
    return samples.left_by(trials)[1]
