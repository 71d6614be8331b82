"""Forward selection along the measured motion: sets grow by one effect a time, each fitted anew.

The screen is linear in all that it adds, at settings that are first guesses, so it misses what only
tells together. Here every set is fitted before it grows, and what may be added to it is scored
beside what it leaves.

Source: Miller, Subset selection in regression, 2002, section 3.2, with a beam.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.candidates import Table, movable
from t2l.detective.choosing import choose
from t2l.detective.fit import begun
from t2l.detective.fitted_set import FittedSet, Start, names_of
from t2l.detective.rule import Judge
from t2l.detective.screen import Screen

GROWING = 2  # numerics: sets that grow at a time, besides the best of each number of effects
ADDED = 6  # numerics: effects that are tried beside each
MOST = 6  # bound: effects in a set
STEPS = 8  # bound: of growing
POLISHING = 2  # numerics: iterations with all derivatives, of what goes on
# numerics: of what the model of the linearised loop leaves, below which that may be what is wrong
FLOOR = 0.02


def growing(
    before: FittedSet,
    sets: Sequence[FittedSet],
    screen: Screen,
    rows: np.ndarray,
    along: AlongMotion,
    folds: np.ndarray,
    judge: Judge,
    linearised_rmse: float,
) -> Iterator[tuple[list[FittedSet], FittedSet]]:
    """Sets with more and more effects, until more gains nothing or only noise is left.

    Args:
        before: the model along the motion.
        sets: fitted along the motion, to grow from.
        screen: beside the model; `rows` (k,) are the places of its samples among the fitted ones.
        linearised_rmse: rad, what the model of which the loop is linearised leaves by simulation.

    Yields:
        After each step the sets with those that grew from them, and the best.
    """
    known = {frozenset(one.names): one for one in sets}
    best, floor = choose(before, sets, judge) or before, FLOOR * linearised_rmse
    exact, grew = set(known), set()
    for _ in range(STEPS):
        left = min((one.left_out_rmse for one in known.values()), default=np.inf)
        if judge.quiet(left) or left < floor:
            break
        small = [one for one in known.values() if len(one.layout.terms) < MOST]
        alike = of_each_size([one for one in small if frozenset(one.names) not in grew])
        # those that grew have some derivatives of the smaller set still
        again = [Start(one.layout, one.u) for one in alike if frozenset(one.names) not in exact]
        done = {frozenset(one.names): one for one in fit_along(again, along, folds, POLISHING)}
        known |= done
        exact |= set(done)
        opened: dict[frozenset, Start] = {}
        for one in alike:
            grew.add(frozenset(one.names))
            more = _with_one_more(known[frozenset(one.names)], screen, rows)
            opened |= {names: start for names, start in more.items() if names not in known}
        fits = fit_along([*opened.values()], along, folds)
        known |= {frozenset(one.names): one for one in fits}
        better = choose(best, fits, judge)
        best = better or best
        yield [*known.values()], best
        if better is None:
            break


def of_each_size(sets: Sequence[FittedSet]) -> list[FittedSet]:
    """Of sets the best, and of each number of effects the best."""
    ranked = sorted(sets, key=lambda one: one.left_out_rmse)
    of_size: dict[int, FittedSet] = {}
    for one in ranked:
        of_size.setdefault(len(one.layout.terms), one)
    some = {id(one): one for one in (*ranked[:GROWING], *of_size.values())}
    return [*some.values()]


def _with_one_more(one: FittedSet, screen: Screen, rows: np.ndarray) -> dict[frozenset, Start]:
    """The most promising sets with an effect more, by their effects and joints."""
    near = _beside(one, screen, rows)
    least = near.score(()).error
    scores = sorted((near.score((i,)) for i in near.growing(())), key=lambda scored: scored.error)
    found: dict[frozenset, Start] = {}
    for scored in scores:
        start = replace(begun(one.model, near, scored.members), columns=one.columns)
        names = frozenset(names_of(start.layout))
        if scored.error < least and names not in found and len(found) < ADDED:
            found[names] = start
    return found


def _beside(one: FittedSet, screen: Screen, rows: np.ndarray) -> Screen:
    """The screen of what may be added to a set."""
    layout, u = one.layout, one.u
    free = [i for i, slot in enumerate(layout.slots) if not slot.parameter.rough]
    on = {term.effect.name: set(term.joints) for term in layout.terms}
    candidates = [
        candidate for candidate in screen.table.candidates
        if candidate.is_new_to(on)
    ]  # fmt: skip
    first, base = screen.table.columns.shape[1], one.jacobian[rows][:, free]
    columns = np.concatenate([screen.table.columns, base.astype(np.float32)], axis=1)
    at = tuple(range(first, first + len(free)))
    table = Table(columns, candidates, at, *movable(layout, u, free))
    return screen.beside(table, -one.residual[rows])
