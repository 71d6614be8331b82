"""Every effect fitted to little data, the likeliest to more, the first to all of it.

Successive halving (Jamieson and Talwalkar, Non-stochastic best arm identification, 2016): all
effects get a few iterations on what is screened, the better half more, the leaders the shortlist.
Sets of effects that explain more together come from `stability_selection`, not from fits.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose import settings
from t2l.diagnose.evidence import Evidence, some
from t2l.diagnose.final_fit import adopted_sizes, from_the_better, is_rough, moves_together
from t2l.diagnose.joint_growth import key_of, on_the_joints_that_show_it, terms_to_try
from t2l.diagnose.joint_start import joined, starts_together
from t2l.diagnose.responses import dictionary_of
from t2l.diagnose.stability_selection import sets, shares
from t2l.diagnose.starting_points import starting_points_of
from t2l.effects.effect import Effect
from t2l.effects.term import Layout
from t2l.identify.fitting import run, start_from_the_best
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.rough import search

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Raced:
    """Every effect fitted.

    Attributes:
        fits: by the effect's name; leaders on the shortlist, the others on what is screened.
        leaders: the likeliest few, best first.
        together: fits of sets of effects, on the shortlist, by their names.
        shares: by name, how often an effect is selected over resamples.
    """

    fits: dict[str, LeastSquares]
    leaders: list[str]
    together: dict[tuple[str, ...], LeastSquares]
    shares: dict[str, float]


def race(
    evidence: Evidence,
    adopted: Layout,
    u: np.ndarray,
    effects: Sequence[Effect],
    progress: Progress,
) -> Raced:
    """Fit every effect on what is screened, the leaders and the likeliest sets on the shortlist.

    While every effect is tried, the derivatives by the model so far are those it has without them.

    Args:
        adopted, u: the model so far.
    """
    screen, mask = evidence.screen, evidence.screen_mask
    progress("first guesses", 0.0)
    diagonal = moves_together(evidence.train.joints)
    so_far = LeastSquares(adopted, u, adopted_sizes(adopted, u), diagonal)
    run([so_far], screen, mask, 0)
    residual = np.full(len(screen.samples), np.nan)
    residual[mask] = so_far.residual
    terms = terms_to_try(effects, adopted, screen, residual)
    guesses = starting_points_of(terms, screen, mask, adopted, u)
    progress("fitting every effect", 0.2)
    tried = {
        key_of(term): LeastSquares(
            layout, start, size, diagonal,
            given={key: c for key, c in so_far.columns().items() if key[0] != term.effect.name},
        )
        for term, ((layout, start, size), _) in zip(terms, guesses, strict=True)
    }  # fmt: skip
    halving(list(tried.values()), screen, mask)
    fits = on_the_joints_that_show_it(tried, evidence)
    fits |= _searched(fits, evidence)
    progress("selecting over resamples", 0.5)
    mild = {key_of(term): response for term, (_, response) in zip(terms, guesses, strict=True)}
    every = tuple(range(len(screen.joints)))
    mild = {name: mild[name, every] for name in fits}
    dictionary = dictionary_of(fits, mild, so_far, evidence)
    selections = list(dictionary.selections())
    chosen = sets(selections, settings.LEADERS)
    together = {names: joined([fits[name] for name in names], names, diagonal) for names in chosen}
    starts = {names: starts_together(fit, names) for names, fit in together.items()}
    start_from_the_best(together, starts, screen, mask)
    run(list(together.values()), screen, mask, settings.ITERATIONS)
    progress("refining the best", 0.7)
    ranked = sorted(fits, key=lambda name: fits[name].loss)
    leaders = ranked[: settings.LEADERS]
    leaders += sorted({n for names in together for n in names} - set(leaders))
    # else they have seen all of it, with derivatives of their own
    if adopted.slots or evidence.shortlist is not screen:
        origin = dict(zip((slot.key for slot in adopted.slots), u, strict=True))
        fits |= _refined({name: fits[name] for name in leaders}, evidence, origin)
        together = _refined(together, evidence, origin)
    return Raced(fits, leaders, together, shares(selections, list(fits)))


def halving(fits: Sequence[LeastSquares], predictor: Predictor, mask: np.ndarray) -> None:
    """A few iterations of all, of the better half, and so on; the last ones to their end."""
    while len(fits) > 2 * settings.LEADERS:
        run(fits, predictor, mask, settings.HALVED_AFTER)
        fits = _better_half(fits)
    run(fits, predictor, mask, settings.ITERATIONS)


def _better_half(fits: Sequence[LeastSquares]) -> list[LeastSquares]:
    return sorted(fits, key=lambda fit: fit.loss)[: -(-len(fits) // 2)]


def _searched(fits: Mapping[str, LeastSquares], evidence: Evidence) -> dict[str, LeastSquares]:
    """Rough effects of the better half where a search finds better than derivatives did."""
    best = _better_half(list(fits.values()))
    rough = {
        name: fit
        for name, fit in fits.items()
        if is_rough(name, fit) and any(fit is b for b in best)
    }
    if not rough:
        return {}
    part = some(evidence.screen, evidence.screen_mask, settings.SCREENED[0])
    found = search(list(rough.values()), *part)
    moved = {
        name: LeastSquares(
            fit.layout, u, fit.size, fit.diagonal,
            given=fit.given,
        )
        for (name, fit), u in zip(rough.items(), found, strict=True)
        if not np.array_equal(u, fit.u)
    }  # fmt: skip
    run(list(moved.values()), evidence.screen, evidence.screen_mask, settings.ITERATIONS)
    return {name: fit for name, fit in moved.items() if fit.loss < rough[name].loss}


def _refined(fits: Mapping, evidence: Evidence, origin: Mapping[tuple, float]) -> dict:
    """Fits to the shortlist; what was adopted before keeps the derivatives of the first round."""
    predictor, mask = evidence.shortlist, evidence.shortlist_mask
    refined = from_the_better(fits, origin, predictor, mask)
    run(list(refined.values()), predictor, mask, 0)
    for key, fit in refined.items():
        names = (key,) if isinstance(key, str) else key
        fit.given = {k: column for k, column in fit.columns().items() if k[0] not in names}
    run(list(refined.values()), predictor, mask, settings.ITERATIONS)
    return refined
