"""Two effects at once, where one alone leaves much unexplained."""

from itertools import combinations

import numpy as np

from t2l.discrepancy.candidate import TIED, Pair
from t2l.discrepancy.evidence import Evidence
from t2l.discrepancy.fit import Fit, drop_hopeless, least_loss, run
from t2l.effects.term import Layout, Term

PAIRED = 5  # best effects that are tried in pairs
ITERATIONS = 5
FAR_BETTER = 0.4  # of the squared error that the best effect leaves


def best_pair(fits: dict[str, Fit], evidence: Evidence, diagonal: bool) -> Pair | None:
    """Two effects that together explain far more than the best one alone.

    What one effect explains is judged wrongly while another of like size is missing: its nearest
    mimic may come out first. Of pairs that explain alike the one with fewer parameters is taken.
    """
    finite = {name: fit for name, fit in fits.items() if np.isfinite(fit.loss)}
    best = sorted(finite, key=lambda name: finite[name].loss)[:PAIRED]
    pairs = {}
    for first, second in combinations(best, 2):
        one, two = _term(finite[first], first).effect, _term(finite[second], second).effect
        if first in two.contains or second in one.contains:
            continue
        pairs[first, second] = _joined(finite[first], finite[second], second, diagonal)
    run(
        list(pairs.values()),
        evidence.screen,
        evidence.screen_mask,
        ITERATIONS,
        drop_hopeless,
    )
    pairs = {names: fit for names, fit in pairs.items() if np.isfinite(fit.loss)}
    if not pairs:
        return None
    least = least_loss(pairs)
    if least > FAR_BETTER * least_loss(fits):
        return None
    alike = [names for names, fit in pairs.items() if fit.loss <= (1 + TIED) ** 4 * least]
    names = min(alike, key=lambda names: (len(pairs[names].layout), pairs[names].loss))
    return Pair(*names, rmse_rad=float(np.sqrt(pairs[names].loss)))


def _term(fit: Fit, name: str) -> Term:
    return next(term for term in fit.layout.terms if term.effect.name == name)


def _joined(fit: Fit, other: Fit, name: str, diagonal: bool) -> Fit:
    """`fit` with the effect `name` of `other` too."""
    layout = Layout([*fit.layout.terms, _term(other, name)])
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
    return Fit(layout, layout.encode(values), size, diagonal, given=given)
