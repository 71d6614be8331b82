"""The first effects of a ranking, fitted to all training samples."""

from collections.abc import Hashable, Iterable, Mapping, Sequence

import numpy as np

from t2l.diagnose import settings
from t2l.diagnose.evidence import Evidence
from t2l.diagnose.idle_joints import without_idle_joints
from t2l.effects.term import Layout
from t2l.identify.fitting import run, start_from_the_best
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.rough import search

Origin = Mapping[tuple, float]  # elements of u by slot key
LEAST_SIZE = 1e-3  # of any unit


def fit_fully(
    fits: Mapping[str, LeastSquares],
    names: Iterable[str],
    evidence: Evidence,
    origin: Origin | None = None,
) -> dict[str, LeastSquares]:
    """The named fits on all training samples, less the joints that show no sign of the effect.

    The last rounds simulate every tick; the derivatives they begin with are those of the draft.

    Args:
        origin: the model so far, fitted to all; few recordings may have led away from it.
    """
    draft, mask = evidence.draft, evidence.train_mask
    full = from_the_better({name: fits[name] for name in names}, origin or {}, draft, mask)
    run(list(full.values()), draft, mask, settings.ITERATIONS)
    smaller = {name: without_idle_joints(name, fit, draft, mask) for name, fit in full.items()}
    smaller = {name: fit for name, fit in smaller.items() if fit is not None}
    run(list(smaller.values()), draft, mask, settings.ITERATIONS)
    full |= {
        n: fit
        for n, fit in smaller.items()
        if fit.loss * (1 - settings.MATERIAL) ** 2 < full[n].loss
    }
    full |= _out_of_dents(full, evidence)
    if draft is evidence.train:
        return full
    finished = {name: fit.again() for name, fit in full.items()}
    run(list(finished.values()), evidence.train, mask, settings.ITERATIONS)
    return finished


def moves_together(joints: Sequence[str]) -> bool:
    """Whether finite differences move all joints at once, each answered by its own motion."""
    return len(joints) >= settings.DIAGONAL_FROM_JOINTS


def adopted_sizes(layout: Layout, u: np.ndarray) -> np.ndarray:
    """(n,) magnitudes of adopted parameters u, for finite differences; of zero, a small one."""
    least = [max(slot.parameter.size, LEAST_SIZE) for slot in layout.slots]
    return np.maximum(np.abs(u), least)


def from_the_better(
    fits: Mapping[Hashable, LeastSquares], origin: Origin, predictor: Predictor, mask: np.ndarray
) -> dict[Hashable, LeastSquares]:
    """Fits from where they ended, or with what was adopted as in `origin`, where that is better."""
    starts = {
        key: np.array(
            [fit.u, [origin.get(s.key, v) for s, v in zip(fit.layout.slots, fit.u, strict=True)]]
        )
        for key, fit in fits.items()
    }
    begun = {key: fit.again() for key, fit in fits.items()}
    start_from_the_best(begun, starts, predictor, mask)
    return begun


def is_rough(name: str, fit: LeastSquares) -> bool:
    """Whether derivatives of effect `name` lead only to the nearest of many minima."""
    return any(t.effect.rough_error for t in fit.layout.terms if t.effect.name == name)


def _out_of_dents(fits: dict[str, LeastSquares], evidence: Evidence) -> dict[str, LeastSquares]:
    """Rough effects where a search around them finds better: derivatives end in the first dent."""
    rough = {name: fit for name, fit in fits.items() if is_rough(name, fit)}
    if not rough:
        return {}
    part = evidence.shortlist, evidence.shortlist_mask
    found = search(list(rough.values()), *part, settings.CLOSE_BY)
    moved = {name: fit.again() for name, fit in rough.items()}
    for fit, u in zip(moved.values(), found, strict=True):
        fit.u = u
    run(list(moved.values()), evidence.draft, evidence.train_mask, 0)
    return {name: fit for name, fit in moved.items() if fit.loss < rough[name].loss}
