"""Two effects at once, where one alone leaves much unexplained."""

from functools import partial
from itertools import combinations

import numpy as np

from t2l.diagnose.candidate import Pair
from t2l.diagnose.evidence import Evidence
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import (
    ITERATIONS,
    LEADERS,
    drop_hopeless,
    least_loss,
    run,
    start_from_the_best,
)
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import MATERIAL, PROMISING, TIED

FAR_BETTER = 1 / PROMISING**2  # derived: of the squared error that the best effect leaves


def best_pair(
    fits: dict[str, LeastSquares], evidence: Evidence, diagonal: bool, before: float
) -> Pair | None:
    """Two effects that together explain far more than the best one alone.

    What one effect explains is judged wrongly while another of like size is missing: its nearest
    mimic may come out first. Of pairs that explain alike the one with fewer parameters is taken.

    Args:
        before: mean squared residual without any of the effects.
    """
    finite = {name: fit for name, fit in fits.items() if np.isfinite(fit.loss)}
    wanted = FAR_BETTER * least_loss(fits)
    pairs = fit_pairs(pairs_to_try(finite, before), finite, evidence, diagonal, wanted)
    if not pairs or least_loss(pairs) > wanted:
        return None
    found = _simplest(pairs)
    tried = {frozenset(names) for names in pairs}
    others = [names for names in _with_one_replaced(found, finite) if frozenset(names) not in tried]
    pairs |= fit_pairs(others, finite, evidence, diagonal, least_loss(pairs))
    names = _simplest(pairs)
    return Pair(*names, pairs[names])


def pairs_to_try(fits: dict[str, LeastSquares], before: float) -> list[tuple[str, str]]:
    """Pairs of the best effects; none where one leaves little and far less than any other.

    It comes first with a partner or without. Of effects that leave alike little, each may be the
    mimic of another with a third.

    Args:
        fits: of single effects, by name.
        before: mean squared residual without any of them.
    """
    best = sorted(fits, key=lambda name: fits[name].loss)[:LEADERS]
    if len(best) < 2:
        return []
    # what leaves less needs no partner yet
    limit = min(MATERIAL * before, fits[best[1]].loss / PROMISING**4)
    return [] if fits[best[0]].loss <= limit else list(combinations(best, 2))


def fit_pairs(
    names: list[tuple[str, str]],
    singles: dict[str, LeastSquares],
    evidence: Evidence,
    diagonal: bool,
    wanted: float,
) -> dict[tuple[str, str], LeastSquares]:
    """Pairs fitted from what each effect alone was fitted to; those that contain another not.

    Args:
        names: the pairs.
        singles: fits of the effects alone, by name.
        diagonal: as in `LeastSquares`.
        wanted: mean squared residual that a pair must come near to be fitted to the end.
    """
    pairs = {}
    for first, second in names:
        one, two = _term(singles[first], first).effect, _term(singles[second], second).effect
        if first not in two.contains and second not in one.contains:
            pairs[first, second] = _joined(singles[first], singles[second], second, diagonal)
    # what one was fitted to while the other was missing may lie far off
    starts = {
        names: np.array([fit.u, *(_without(fit, name) for name in names)])
        for names, fit in pairs.items()
    }
    start_from_the_best(pairs, starts, evidence.screen, evidence.screen_mask)
    hopeless = partial(drop_hopeless, best=wanted)
    run(list(pairs.values()), evidence.screen, evidence.screen_mask, ITERATIONS, hopeless)
    return {names: fit for names, fit in pairs.items() if np.isfinite(fit.loss)}


def _without(fit: LeastSquares, name: str) -> np.ndarray:
    """u (n,) of a fit with effect `name` absent, or as nearly as its bounds allow."""
    u = fit.u.copy()
    for i, slot in enumerate(fit.layout.slots):
        if slot.term.effect.name == name and not np.isnan(slot.parameter.neutral):
            u[i] = fit.layout.neutral[i]
    return u


def _simplest(pairs: dict[tuple[str, str], LeastSquares]) -> tuple[str, str]:
    """Of pairs that explain alike, the one with fewest parameters."""
    limit = (1 + TIED) ** 4 * least_loss(pairs)
    alike = [names for names, fit in pairs.items() if fit.loss <= limit]
    return min(alike, key=lambda names: (len(pairs[names].layout), pairs[names].loss))


def _with_one_replaced(
    pair: tuple[str, str], singles: dict[str, LeastSquares]
) -> list[tuple[str, str]]:
    """Pairs in which an effect of no more parameters stands for one of the two."""
    return [
        (kept, name)
        for kept, replaced in (pair, pair[::-1])
        for name, fit in singles.items()
        if name not in pair and len(fit.layout) <= len(singles[replaced].layout)
    ]


def _term(fit: LeastSquares, name: str) -> Term:
    return next(term for term in fit.layout.terms if term.effect.name == name)


def _joined(fit: LeastSquares, other: LeastSquares, name: str, diagonal: bool) -> LeastSquares:
    """`fit` with the effect `name` of `other` too."""
    # the model so far may have it on some joints already
    rest = [term for term in fit.layout.terms if term.effect.name != name]
    layout = Layout([*rest, _term(other, name)])
    values = {k: {p: v[0] for p, v in d.items()} for k, d in fit.layout.decode(fit.u[None]).items()}
    theirs = other.layout.decode(other.u[None])[name]
    values[name] = {parameter: value[0] for parameter, value in theirs.items()}
    sizes = {
        slot.key: size
        for source in (other, fit)
        for slot, size in zip(source.layout.slots, source.size, strict=True)
    }
    size = np.array([sizes[slot.key] for slot in layout.slots])
    given = {key: column for key, column in fit.given.items() if key[0] != name}
    return LeastSquares(layout, layout.encode(values), size, diagonal, given=given)
