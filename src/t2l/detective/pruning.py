"""Terms that a set has and does not need."""

from collections.abc import Callable, Set

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.fit import Samples, finish, fit_sets
from t2l.detective.fitted_set import FittedSet, Start, names_of, sizes
from t2l.detective.rule import Judge
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import PROMISING
from t2l.identify.optimiser import minimise

LEAST_TRIED = 2  # numerics: sets without a term, that are simulated whatever is foretold
SURELY = 2.0  # numerics: times the error at which a term is missed, as derivatives foretell it


def pruned(
    better: FittedSet,
    samples: Samples,
    judge: Judge,
    along: AlongMotion,
    before: FittedSet,
    over: Callable[[], bool],
) -> FittedSet:
    """What is left of a set, by simulation, that takes the place of a model.

    Args:
        before: the model.
        over: whether the time is.
    """

    def fit(whole: FittedSet, trials: list[Start]) -> list[FittedSet]:
        """By simulation, but for what is missed along the motion already and others less."""
        if trials:
            start = Start(whole.layout, whole.u)
            led = fit_along([start, *trials], along, samples.folds)
            of = {frozenset(f.names): f for f in sorted(led, key=lambda f: f.left_out_rmse)}
            known = of.pop(frozenset(whole.names), None)
            missed = {n for n, f in of.items() if known is not None and judge.misses(known, f)}
            missed -= {*list(of)[:LEAST_TRIED]}
            trials = [t for t in trials if frozenset(names_of(t.layout)) not in missed]
        return fit_sets(trials, samples, along, before.known)

    def stands(one: FittedSet) -> bool:
        return judge.takes(before, one)

    return prune(better, judge, along, fit, lambda sets: finish(sets, samples, along), over, stands)


def pruned_along(
    promised: FittedSet,
    along: AlongMotion,
    judge: Judge,
    folds: np.ndarray,
    over: Callable[[], bool],
) -> FittedSet:
    """Likewise of a set that is only promised, along the motion."""

    def fit(_: FittedSet, trials: list[Start]) -> list[FittedSet]:
        return fit_along(trials, along, folds)

    return prune(promised, judge, along, fit, over=over)


def prune(
    better: FittedSet,
    judge: Judge,
    along: AlongMotion,
    fit: Callable[[FittedSet, list[Start]], list[FittedSet]],
    finish: Callable[[list[FittedSet]], list[FittedSet]] = lambda sets: sets,
    over: Callable[[], bool] = lambda: False,
    stands: Callable[[FittedSet], bool] = lambda one: True,
) -> FittedSet:
    """Drop terms, joint by joint, that the rule does not miss beside the best set on the way.

    Beside the last one alone, many small losses would add up to a large one.

    Args:
        fit: fits what is left of a set when a term goes; `finish` does the same to the end.
        over: whether the time is: then what is not dropped stays.
        stands: what must hold of what is left, beside.
    """
    best = better

    def enough(some: list[FittedSet]) -> list[FittedSet]:
        return [f for f in some if not judge.misses(best, f) and stands(f)]

    while not over():
        trials = worth_a_fit(better, without_one(better), along)
        kept = enough(fit(better, trials))
        kept.sort(key=lambda f: f.left_out_rmse)
        # what may go one by one often may go together, which saves as many fits
        for many in (kept, kept[: len(kept) // 2]):
            gone = {pair for f in many for pair in _pairs(better.layout) - _pairs(f.layout)}
            if len(many) > 1 and gone < _pairs(better.layout):
                fewer = enough(finish(fit(better, [without(better, gone)])))
                if fewer:
                    break
        else:
            fewer = enough(finish(kept[:2]))
        if not fewer:
            break
        better = min(fewer, key=lambda f: f.left_out_rmse)
        best = min(best, better, key=lambda f: f.left_out_rmse)
    return better


def worth_a_fit(whole: FittedSet, trials: list[Start], along: AlongMotion) -> list[Start]:
    """Without those of a set that leave far too much, as its derivatives foretell it."""
    begun = [Start(whole.layout, whole.u, whole.columns), *trials]
    fits = [
        LeastSquares(s.layout, s.u, sizes(s), given=dict(s.columns), noise=along.noise_rad)
        for s in begun
    ]
    minimise(fits, along, 0)
    # along the motion the set itself may leave more or less than by simulation
    limit = SURELY * PROMISING * max(fits[0].loss ** 0.5, whole.left_out_rmse)
    left = [fit.promised() ** 0.5 for fit in fits[1:]]
    return [t for t, error in zip(trials, left, strict=True) if error <= limit]


def without_one(whole: FittedSet) -> list[Start]:
    """A set without each of its terms, joint by joint where each has numbers of its own."""
    trials, every = [], _pairs(whole.layout)
    for term in whole.layout.terms:
        name, apart = term.effect.name, any(p.per_joint for p in term.effect.parameters)
        ones = [{(name, joint)} for joint in term.joints]
        if not apart or whole.shares(term):
            ones = [set().union(*ones)]
        trials += [without(whole, gone) for gone in ones if gone < every]
    return trials


def without(whole: FittedSet, gone: Set[tuple[str, int]]) -> Start:
    """A set without some effects on some joints."""
    old = {s.key: v for s, v in zip(whole.layout.slots, whole.u, strict=True)}
    left = {
        term.effect: tuple(j for j in term.joints if (term.effect.name, j) not in gone)
        for term in whole.layout.terms
    }
    layout = Layout([Term(effect, joints) for effect, joints in left.items() if joints])
    known = whole.columns
    columns = {s.key: known[s.key] for s in layout.slots if s.key in known}
    u = np.array([old[s.key] for s in layout.slots])
    return Start(layout, u, columns, whole.beyond)


def _pairs(layout: Layout) -> set[tuple[str, int]]:
    """Effects with each joint that has them."""
    return {(term.effect.name, joint) for term in layout.terms for joint in term.joints}
