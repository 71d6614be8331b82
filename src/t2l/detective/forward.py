"""Forward selection along the measured motion: sets grow by one effect a time, each fitted anew.

The screen is linear in all that it adds, at settings that are first guesses, so it misses what only
tells together. Here every set is fitted before it grows, and what may be added to it is scored
beside what it leaves.

Where nothing that is added earns its place any more, effects are exchanged: sets lose one, and get
another in its place. What was taken early, while others were missing, may be a mimic.

Source: Miller, Subset selection in regression, 2002, sections 3.2, with a beam, and 3.5,
sequential replacement.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.candidates import do_the_same, movable
from t2l.detective.choosing import BETTER, choose
from t2l.detective.fit import begun
from t2l.detective.fitted_set import FittedSet, Start, names_of
from t2l.detective.rule import Judge
from t2l.detective.screen import Screen
from t2l.effects.term import Layout, Term
from t2l.identify.levels import HALF

GROWING = 2  # numerics: sets that grow at a time, besides the best of each number of effects
ADDED = 6  # numerics: effects that are tried beside each
# numerics: effects that are tried in the place of each, and sets with one exchanged that are fitted
REPLACING, EXCHANGED = 3, 24
MOST = 6  # bound: effects in a set
STEPS = 8  # bound: of growing
LITTLE = 2.0  # tuned: times the noise, what is left where sets do not grow
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
        # what little is left beside noise a simulation tells, and the next round
        if left <= max(LITTLE * judge.noise_rad, floor):
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
            opened |= {names: start for names, (_, start) in more.items() if names not in known}
        fits = fit_along([*opened.values()], along, folds, racing=True)
        known |= {frozenset(one.names): one for one in fits}
        better = choose(best, fits, judge)
        if better is None or better.left_out_rmse >= best.left_out_rmse:
            best = better or best
            some = of_each_size([*known.values()])
            others = _exchanged(some, screen, rows, along, folds, set(known))
            fits = fit_along(others, along, folds, racing=True)
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


def _exchanged(
    sets: Sequence[FittedSet],
    screen: Screen,
    rows: np.ndarray,
    along: AlongMotion,
    folds: np.ndarray,
    known: set[frozenset],
) -> list[Start]:
    """Sets with another effect in the place of one that is missed, the most promising first."""
    fewer: dict[frozenset, tuple[Start, float, str]] = {}
    for one in sets:
        for term in one.layout.terms:
            start = _without(one, term)
            of = start, one.left_out_rmse, term.effect.name
            fewer.setdefault(frozenset(names_of(start.layout)), of)
    found: dict[frozenset, tuple[tuple[int, float], Start]] = {}
    starts = [start for start, _, _ in fewer.values()]
    for rest in fit_along(starts, along, folds, POLISHING):
        _, before, gone = fewer[frozenset(names_of(rest.layout))]
        if before > BETTER * rest.left_out_rmse:
            continue
        least = (HALF * rest.left_out_rmse) ** 2
        more = _with_one_more(rest, screen, rows, REPLACING, gone)
        for place, (names, (error, start)) in enumerate(more.items()):
            if names not in known and error < least:
                found.setdefault(names, ((place, error), start))
    ranked = sorted(found.values(), key=lambda one: one[0])
    return [start for _, start in ranked[:EXCHANGED]]


def _without(one: FittedSet, term: Term) -> Start:
    """A set less one of its terms, with the derivatives of the others."""
    rest = Layout([other for other in one.layout.terms if other is not term])
    keys = {slot.key for slot in rest.slots}
    u = [value for slot, value in zip(one.layout.slots, one.u, strict=True) if slot.key in keys]
    columns = {key: column for key, column in one.columns.items() if key in keys}
    return Start(rest, np.array(u), columns)


def _with_one_more(
    one: FittedSet, screen: Screen, rows: np.ndarray, most: int = ADDED, but: str = ""
) -> dict[frozenset, tuple[float, Start]]:
    """The most promising sets with an effect more and their scores, by effects and joints.

    Args:
        but: an effect that is not added.
    """
    near = _beside(one, screen, rows)
    least = near.score(()).error
    scores = sorted((near.score((i,)) for i in near.growing(())), key=lambda scored: scored.error)
    found: dict[frozenset, tuple[float, Start]] = {}
    for scored in scores:
        (added,) = near.chosen(scored.members)
        if scored.error >= least or added.effect.name == but or len(found) >= most:
            continue
        start = replace(begun(one.model, near, scored.members), columns=one.columns)
        found.setdefault(frozenset(names_of(start.layout)), (scored.error, start))
    return found


def _beside(one: FittedSet, screen: Screen, rows: np.ndarray) -> Screen:
    """The screen of what may be added to a set."""
    layout, u = one.layout, one.u
    free = [i for i, slot in enumerate(layout.slots) if not slot.parameter.rough]
    on = {term.effect.name: set(term.joints) for term in layout.terms}
    new = [
        i for i, some in enumerate(screen.table.candidates)
        if some.is_new_to(on) and not any(do_the_same(some, term) for term in layout.terms)
    ]  # fmt: skip
    derivatives, limits = one.jacobian[rows][:, free], movable(layout, u, free)
    return screen.beside(new, derivatives, limits, -one.residual[rows])
