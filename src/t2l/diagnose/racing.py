"""Every effect fitted on a few recordings, the likeliest on more, the first on all of them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.candidate import Pair
from t2l.diagnose.evidence import Evidence, some
from t2l.diagnose.idle_joints import IDLE, without_idle_joints
from t2l.diagnose.joint_growth import on_the_joints_that_show_it
from t2l.diagnose.pairs import best_pair
from t2l.diagnose.responses import dictionary_of
from t2l.diagnose.settings import SCREENED
from t2l.diagnose.starting_points import (
    SCREENING_TOLERANCE,
    Start,
    begun,
    starting_points_of,
)
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import (
    ITERATIONS,
    LEADERS,
    REFINEMENTS,
    drop_hopeless,
    least_loss,
    run,
    start_from_the_best,
)
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import AT_THE_FLOOR, NEGLIGIBLE, PROMISING, TIED
from t2l.identify.prediction import Predictor, Request
from t2l.identify.progress import Progress
from t2l.identify.rough import search

DIAGONAL_FROM_JOINTS = 4  # tuned: joints from which the search moves them all at once
NEAR = PROMISING**4  # derived: times the least loss: what may still turn out to be best
SEARCHED_NEAR = AT_THE_FLOOR**2  # derived: likewise, for a search that takes many simulations
LEAST_SIZE = 1e-3  # numerics: of the scale of an adopted parameter, for finite differences
CLOSE_BY = 0.25  # tuned: of the spread of that search, where a fit to all recordings has ended
SETTLED = 1 - TIED  # derived: of the loss before; a fit that ends above is at its minimum

Origin = Mapping[tuple, float]  # elements of u by slot key


@dataclass(frozen=True)
class Fitted:
    """Every effect fitted.

    Attributes:
        fits: by the effect's name; leaders on the shortlist, the others on what is screened.
        leaders: the likeliest few, best first.
        pair: two effects that explain far more together.
        shares: by name, in what share of the resamples an effect explains as well as anything;
            None where that cannot be told.
    """

    fits: dict[str, LeastSquares]
    leaders: list[str]
    pair: Pair | None
    shares: dict[str, float | None]


def fit_all(
    evidence: Evidence,
    adopted: Layout,
    u: np.ndarray,
    effects: Sequence[Effect],
    floor: float,
    progress: Progress,
) -> Fitted:
    """Fit every effect on what is screened, and the leaders on the shortlist.

    While every effect is tried, the derivatives by the model so far are those it has without them.

    Args:
        adopted, u: the model so far.
        floor: RMSE in rad below which nothing is missing.
    """
    screen, mask = evidence.screen, evidence.screen_mask
    diagonal = moves_together(evidence.train.joints)
    progress("first guesses", 0.0)
    least = [max(slot.size, LEAST_SIZE * slot.scale) for slot in adopted.slots]
    so_far = LeastSquares(adopted, u, np.maximum(np.abs(u), least), diagonal)
    run([so_far], screen, mask, 0)
    every = tuple(range(len(screen.joints)))
    terms = [Term(effect, every) for effect in effects]
    guesses = starting_points_of(terms, screen, mask, adopted, u)
    progress("fitting every effect", 0.2)
    first = {term.effect.name: start for term, (start, _) in zip(terms, guesses, strict=True)}
    fits = {t.effect.name: begun(t, first[t.effect.name], so_far) for t in terms}
    run(list(fits.values()), screen, mask, ITERATIONS, drop_hopeless)
    # where one on all joints leaves little but noise, none on fewer explains more
    if least_loss(fits) > (AT_THE_FLOOR**2 * floor) ** 2:
        fits |= on_the_joints_that_show_it(fits, so_far, evidence)
    fits |= _searched(fits, evidence)
    mild = {term.effect.name: response for term, (_, response) in zip(terms, guesses, strict=True)}
    told = dictionary_of(fits, mild, so_far, evidence).shares()
    # of what every simulation ran away with there is no response
    chosen = {name: told.get(name) for name in fits}
    pair = None
    # an effect that leaves more may have a companion
    if least_loss(fits) > (PROMISING * floor) ** 2:
        progress("trying pairs of effects", 0.5)
        pair = best_pair(fits, evidence, diagonal, so_far.loss)
    progress("refining the best", 0.7)
    leaders = _leaders(fits, pair)
    origin = dict(zip((slot.key for slot in adopted.slots), u, strict=True))
    # else they have seen all of it, with derivatives of their own
    if adopted.slots or evidence.shortlist is not screen:
        fits |= _refined({name: fits[name] for name in leaders}, evidence, origin)
    if evidence.shortlist.coarseness > 1:
        fits |= _on_every_tick({name: fits[name] for name in leaders}, first, evidence, floor)
    return Fitted(fits, leaders, pair, chosen)


def _on_every_tick(
    leaders: Mapping[str, LeastSquares],
    first: Mapping[str, Start],
    evidence: Evidence,
    floor: float,
) -> dict[str, LeastSquares]:
    """Leaders that feel coarse ticks more than a tie allows, fitted on every tick from their ends.

    And from the first guess, where more than noise is left: coarse ticks may have minima of their
    own.
    """
    mask = evidence.shortlist_mask
    exact = evidence.shortlist.of(evidence.shortlist.recordings, 1)
    requests = [Request(fit.layout, fit.u[None]) for fit in leaders.values()]
    fits = {}
    for (name, fit), (q,) in zip(leaders.items(), exact.predict(requests), strict=True):
        felt = np.sqrt(np.mean(((q - exact.samples.q)[mask] - fit.residual) ** 2))
        if not felt <= NEGLIGIBLE * floor:
            fits[name] = fit.again()
    run(list(fits.values()), exact, mask, ITERATIONS)
    anew = {
        name: _from_guess(fit, first[name])
        for name, fit in fits.items()
        if not fit.loss <= (AT_THE_FLOOR**2 * floor) ** 2
    }
    run(list(anew.values()), exact, mask, ITERATIONS)
    return fits | {name: fit for name, fit in anew.items() if fit.loss < fits[name].loss}


def _from_guess(fit: LeastSquares, first: Start) -> LeastSquares:
    """The same fit from a first guess of its effect on all joints."""
    layout, guess, _ = first
    values = dict(zip((slot.key for slot in layout.slots), guess, strict=True))
    start = np.array([values[slot.key] for slot in fit.layout.slots])
    return LeastSquares(fit.layout, start, fit.size, fit.diagonal)


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
    predictor, mask = evidence.train, evidence.train_mask
    full = _from_the_better({name: fits[name] for name in names}, origin or {}, predictor, mask)
    _settle(list(full.values()), predictor, mask)
    smaller = {name: without_idle_joints(name, fit, predictor, mask) for name, fit in full.items()}
    smaller = {name: fit for name, fit in smaller.items() if fit is not None}
    run(list(smaller.values()), predictor, mask, REFINEMENTS)
    # what a joint contributes beyond that is kept
    full |= {n: fit for n, fit in smaller.items() if fit.loss < IDLE**2 * full[n].loss}
    return full | _out_of_dents(full, evidence)


def moves_together(joints: Sequence[str]) -> bool:
    """Whether finite differences move all joints at once, each answered by its own motion."""
    return len(joints) >= DIAGONAL_FROM_JOINTS


def _from_the_better(
    fits: dict[str, LeastSquares], origin: Origin, predictor: Predictor, mask: np.ndarray
) -> dict[str, LeastSquares]:
    """Fits from where they ended, or with what was adopted as in `origin`, where that is better."""
    starts = {
        name: np.array(
            [fit.u, [origin.get(s.key, v) for s, v in zip(fit.layout.slots, fit.u, strict=True)]]
        )
        for name, fit in fits.items()
    }
    anew = {name: fit.again() for name, fit in fits.items()}
    if origin:
        start_from_the_best(anew, starts, predictor, mask)
    return anew


def _settle(fits: list[LeastSquares], predictor: Predictor, mask: np.ndarray) -> None:
    """Fit with derivatives taken anew only where the last ones still gained much."""
    left = fits
    for _ in range(REFINEMENTS):
        for fit in left:
            fit.given, fit.jacobian, fit.done = {}, None, False
        run(left, predictor, mask, 0)
        before = [fit.loss for fit in left]
        for fit in left:
            fit.given = fit.columns()
        run(left, predictor, mask, REFINEMENTS)
        left = [fit for fit, loss in zip(left, before, strict=True) if fit.loss < SETTLED * loss]


def _out_of_dents(fits: dict[str, LeastSquares], evidence: Evidence) -> dict[str, LeastSquares]:
    """Rough effects where a search around them finds better: derivatives end in the first dent."""
    rough = {name: fit for name, fit in fits.items() if _is_rough(name, fit)}
    if not rough:
        return {}
    # a dent has its place on every tick
    exact = evidence.shortlist.of(evidence.shortlist.recordings, 1)
    found = search(list(rough.values()), exact, evidence.shortlist_mask, CLOSE_BY)
    moved = {name: fit.again() for name, fit in rough.items()}
    for fit, u in zip(moved.values(), found, strict=True):
        fit.u = u
    run(list(moved.values()), evidence.train, evidence.train_mask, 0)
    return {name: fit for name, fit in moved.items() if fit.loss < rough[name].loss}


def _is_rough(name: str, fit: LeastSquares) -> bool:
    return any(t.effect.rough_error for t in fit.layout.terms if t.effect.name == name)


def _searched(fits: dict[str, LeastSquares], evidence: Evidence) -> dict[str, LeastSquares]:
    """Rough effects where a search finds better than derivatives did."""
    rough = {
        name: fit
        for name, fit in fits.items()
        if _is_rough(name, fit) and fit.loss <= SEARCHED_NEAR * least_loss(fits)
    }
    if not rough:
        return {}
    found = search(list(rough.values()), *some(evidence.screen, evidence.screen_mask, SCREENED[0]))
    moved = {
        name: LeastSquares(
            fit.layout, u, fit.size, fit.diagonal, tolerance=SCREENING_TOLERANCE, given=fit.given
        )
        for (name, fit), u in zip(rough.items(), found, strict=True)
        if not np.array_equal(u, fit.u)
    }
    run(list(moved.values()), evidence.screen, evidence.screen_mask, REFINEMENTS)
    return {name: fit for name, fit in moved.items() if fit.loss < rough[name].loss}


def _leaders(fits: dict[str, LeastSquares], pair: Pair | None) -> list[str]:
    """Names of the few effects worth fitting on everything, best first."""
    ranked = sorted(fits, key=lambda name: fits[name].loss)
    best = fits[ranked[0]].loss
    near = [name for name in ranked if fits[name].loss <= NEAR * best]
    leaders = near[:LEADERS] if len(near) > 1 else ranked[:2]
    members = [] if pair is None else [pair.first, pair.second]
    return leaders + [name for name in members if name not in leaders]


def _refined(
    fits: dict[str, LeastSquares], evidence: Evidence, origin: Origin
) -> dict[str, LeastSquares]:
    """Fits to the shortlist; what was adopted before keeps the derivatives of the first round."""
    predictor, mask = evidence.shortlist, evidence.shortlist_mask
    refined = _from_the_better(fits, origin, predictor, mask)
    run(list(refined.values()), predictor, mask, 0)
    for name, fit in refined.items():
        fit.given = {key: column for key, column in fit.columns().items() if key[0] != name}
    run(list(refined.values()), predictor, mask, REFINEMENTS, drop_hopeless)
    return refined
