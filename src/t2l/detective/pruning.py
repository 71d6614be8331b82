"""Terms that a set has and does not need."""

from collections.abc import Callable

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.fit import Samples, finish, fit_sets
from t2l.detective.fitted_set import FittedSet, Known, Start, names_of
from t2l.detective.rule import Judge
from t2l.effects.term import Layout, Term

PRUNING = 3  # numerics: iterations of a fit with a term less


def pruned(
    better: FittedSet, samples: Samples, judge: Judge, along: AlongMotion, so_far: Known
) -> FittedSet:
    """What is left of a set, by simulation.

    Args:
        so_far: the model before it, and what that leaves on every tick.
    """

    def fit(whole: FittedSet, trials: list[Start]) -> list[FittedSet]:
        """By simulation, but for what is missed along the motion already."""
        if along.can_lead(whole.layout):
            start = Start(whole.layout, whole.u)
            led = fit_along([start, *trials], along, samples.folds)
            of = {frozenset(f.names): f for f in led}
            known = of.get(frozenset(whole.names))
            missed = {n for n, f in of.items() if known is not None and judge.misses(known, f)}
            trials = [t for t in trials if frozenset(names_of(t.layout)) not in missed]
        return fit_sets(trials, samples, along, so_far, PRUNING)

    return prune(better, judge, fit, lambda sets: finish(sets, samples, along))


def pruned_along(
    promised: FittedSet, along: AlongMotion, judge: Judge, folds: np.ndarray
) -> FittedSet:
    """Likewise of a set that is only promised, along the motion."""
    return prune(promised, judge, lambda _, trials: fit_along(trials, along, folds))


def prune(
    better: FittedSet,
    judge: Judge,
    fit: Callable[[FittedSet, list[Start]], list[FittedSet]],
    finish: Callable[[list[FittedSet]], list[FittedSet]] = lambda sets: sets,
) -> FittedSet:
    """Drop terms, joint by joint, that the rule does not miss.

    Args:
        fit: fits what is left of a set when a term goes; `finish` does the same to the end.
    """
    while True:
        kept = [f for f in fit(better, _without_one(better)) if not judge.misses(better, f)]
        kept = finish(sorted(kept, key=lambda f: f.left_out_rmse)[:2])
        kept = [f for f in kept if not judge.misses(better, f)]
        if not kept:
            return better
        better = min(kept, key=lambda f: f.left_out_rmse)


def _without_one(whole: FittedSet) -> list[Start]:
    old = {s.key: v for s, v in zip(whole.layout.slots, whole.u, strict=True)}
    known, trials = whole.columns, []
    for term in whole.layout.terms:
        others = [t for t in whole.layout.terms if t is not term]
        fewer = [tuple(j for j in term.joints if j != gone) for gone in term.joints]
        if not any(p.per_joint for p in term.effect.parameters) or len(term.joints) == 1:
            fewer = [()]
        for joints in fewer:
            layout = Layout([*others, Term(term.effect, joints)] if joints else others)
            if layout.terms:
                u = np.array([old[s.key] for s in layout.slots])
                columns = {s.key: known[s.key] for s in layout.slots if s.key in known}
                trials.append(Start(layout, u, columns))
    return trials
