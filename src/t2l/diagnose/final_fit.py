"""The first effects of a ranking, fitted to all training samples."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from t2l.diagnose import settings
from t2l.diagnose.evidence import Evidence
from t2l.diagnose.idle_joints import without_idle_joints
from t2l.identify.fitting import run, start_from_the_best
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.rough import search

Origin = Mapping[tuple, float]  # elements of u by slot key


def fit_fully(
    fits: dict[str, LeastSquares],
    names: Iterable[str],
    evidence: Evidence,
    origin: Origin | None = None,
) -> dict[str, LeastSquares]:
    """The named fits on all training samples, less the joints that show no sign of the effect.

    Args:
        origin: the model so far, fitted to all; few recordings may have led away from it.
    """
    chosen, origin = {name: fits[name] for name in names}, origin or {}
    full = _fitted_fully(chosen, origin, evidence, evidence.draft)
    if evidence.draft is evidence.train:
        return full
    drafts, full = full, _finished(full, evidence)
    _settle([full[n] for n in _lost(full, drafts)], evidence.train, evidence.train_mask)
    # near where a simulation runs away its ticks decide
    lost = {name: chosen[name] for name in _lost(full, drafts)}
    return full | (_fitted_fully(lost, origin, evidence, evidence.train) if lost else {})


def _fitted_fully(
    fits: dict[str, LeastSquares], origin: Origin, evidence: Evidence, predictor: Predictor
) -> dict[str, LeastSquares]:
    mask = evidence.train_mask
    full = from_the_better(fits, origin, predictor, mask)
    _settle(list(full.values()), predictor, mask)
    smaller = {name: without_idle_joints(name, fit, predictor, mask) for name, fit in full.items()}
    smaller = {name: fit for name, fit in smaller.items() if fit is not None}
    run(list(smaller.values()), predictor, mask, settings.REFINEMENTS)
    # what a joint contributes beyond 1 % of the error is kept
    full |= {n: fit for n, fit in smaller.items() if fit.loss < 1.02 * full[n].loss}
    return full | _out_of_dents(full, evidence, predictor)


def moves_together(joints: Sequence[str]) -> bool:
    """Whether finite differences move all joints at once, each answered by its own motion."""
    return len(joints) >= settings.DIAGONAL_FROM_JOINTS


def from_the_better(
    fits: dict[str, LeastSquares], origin: Origin, predictor: Predictor, mask: np.ndarray
) -> dict[str, LeastSquares]:
    """Fits from where they ended, or with what was adopted as in `origin`, where that is better."""
    starts = {
        name: np.array(
            [fit.u, [origin.get(s.key, v) for s, v in zip(fit.layout.slots, fit.u, strict=True)]]
        )
        for name, fit in fits.items()
    }
    begun = {name: fit.again() for name, fit in fits.items()}
    start_from_the_best(begun, starts, predictor, mask)
    return begun


def _settle(fits: list[LeastSquares], predictor: Predictor, mask: np.ndarray) -> None:
    """Fit with derivatives taken anew only where the last ones still gained much."""
    left = fits
    for _ in range(settings.RESTARTS):
        for fit in left:
            fit.given, fit.jacobian, fit.done = {}, None, False
        run(left, predictor, mask, 0)
        before = [fit.loss for fit in left]
        for fit in left:
            fit.given = fit.columns()
        run(left, predictor, mask, settings.REFINEMENTS)
        left = [
            fit
            for fit, loss in zip(left, before, strict=True)
            if fit.loss < settings.SETTLED * loss
        ]


def _lost(fits: dict[str, LeastSquares], drafts: dict[str, LeastSquares]) -> list[str]:
    return [name for name, fit in fits.items() if not fit.loss < settings.LOST * drafts[name].loss]


def _finished(fits: dict[str, LeastSquares], evidence: Evidence) -> dict[str, LeastSquares]:
    """Fits to the draft of all recordings, with their derivatives, fitted to them in full."""
    finished = {name: fit.again() for name, fit in fits.items()}
    for name, fit in finished.items():
        fit.given = fits[name].columns()
    run(list(finished.values()), evidence.train, evidence.train_mask, settings.FINISHING)
    return finished


def _out_of_dents(
    fits: dict[str, LeastSquares], evidence: Evidence, predictor: Predictor
) -> dict[str, LeastSquares]:
    """Rough effects where a search around them finds better: derivatives end in the first dent."""
    rough = {name: fit for name, fit in fits.items() if _is_rough(name, fit)}
    if not rough:
        return {}
    found = search(
        list(rough.values()), evidence.shortlist, evidence.shortlist_mask, settings.CLOSE_BY
    )
    moved = {name: fit.again() for name, fit in rough.items()}
    for fit, u in zip(moved.values(), found, strict=True):
        fit.u = u
    run(list(moved.values()), predictor, evidence.train_mask, 0)
    return {name: fit for name, fit in moved.items() if fit.loss < rough[name].loss}


def _is_rough(name: str, fit: LeastSquares) -> bool:
    return any(t.effect.rough_error for t in fit.layout.terms if t.effect.name == name)
