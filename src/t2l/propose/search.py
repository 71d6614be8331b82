"""Laws taken one after the other: the one that leaves least where it was neither fitted nor chosen.

A round simulates the response to every law's basis functions at the present model, which makes the
best curve of each law a linear fit, on some samples, with a penalty that others choose. The laws
that promise most are fitted through the simulation, and the one that leaves least on the choosing
samples is taken, if a paired block bootstrap there finds that it earns its place; of laws that the
bootstrap cannot tell from it, the simplest.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.diagnose.ranking import rms
from t2l.diagnose.settings import MOST_EFFECTS, SCREENED
from t2l.effects.law import SIGNED, Law
from t2l.effects.learned import SplineTorque
from t2l.identify.block_bootstrap import blocks, improvement
from t2l.identify.fitting import LEADERS
from t2l.identify.levels import AT_THE_FLOOR, HALF, MATERIAL, PROMISING, TIED
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.scales import scales
from t2l.propose.bases import effect_of, may_be_finer, penalty
from t2l.propose.dictionary import joined, responses, term_of, weights_in
from t2l.propose.laws import laws, order, ranges
from t2l.propose.refit import (
    State,
    begin_at_the_best,
    coarser,
    columns,
    finish,
    off,
    refit,
    without,
)
from t2l.propose.ridge import Fit, fit
from t2l.propose.split import few
from t2l.recordings.recording import Recording

LEAST_IMPROVEMENT = MATERIAL  # of the error; less is no finding
ALIKE = TIED  # of the error between laws that explain alike
NEAR = AT_THE_FLOOR  # times the least error after them: laws that are fitted to the end
MOST_LAWS = MOST_EFFECTS  # more is a model that fits anything
SEED = 0  # statistics: of the bootstrap

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Ceiling:
    """What one law alone can explain.

    Attributes:
        rmse_rad: on the choosing samples.
        simulated: whether the curve was simulated, or its response taken as linear.
    """

    law: Law
    rmse_rad: float
    simulated: bool


@dataclass
class Search:
    """What was found.

    Attributes:
        state: the model's effects with the laws that were taken.
        baseline_rad, rmse_rad: on the choosing samples, of the model and with the laws.
        noise_floor_rad: on all samples.
        ceilings: of every law beside the model, in the first round.
        residual: (nsample,) measured minus predicted, with the laws.
    """

    state: State
    baseline_rad: float
    rmse_rad: float
    noise_floor_rad: float
    residual: np.ndarray
    ceilings: list[Ceiling] = field(default_factory=list)

    @property
    def laws(self) -> list[SplineTorque]:
        """That were taken, in their order."""
        return [effect for effect, _ in self.state.laws]


def search(
    model: Model,
    predictor: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
    progress: Progress = lambda what, fraction: None,
    most: int = MOST_LAWS,
    others: Sequence[Recording] = (),
) -> Search:
    """Laws that explain what `model` leaves of the recordings.

    Args:
        fitted, chosen: (nsample,) bool, samples to fit and samples to choose by.
        others: recordings that the laws must also predict, see `t2l.propose.laws.ranges`.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    layout, u = model.vector(predictor.joints)
    state = State(layout, u)
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    check_finite(q[0], predictor)
    left = predictor.samples.q - q[0]
    baseline = rms(left[chosen])
    floor = noise_floor(list(predictor.recordings), predictor.samples.by_row(left))
    found = Search(state, baseline, baseline, floor, left)
    ends, torque = ranges(predictor, q[0], dq[0], others), scales(predictor).torque
    draft = coarser(predictor, state)
    for number in range(most):
        if not _still_more(found):
            break
        progress(f"learning curve {number + 1}", number / most)
        if not _take_one(found, predictor, draft, fitted, chosen, ends, torque):
            break
    return found


def _take_one(
    found: Search,
    predictor: Predictor,
    draft: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
    ends: dict[Law, tuple[float, ...]],
    torque: np.ndarray,
) -> bool:
    """Add the law that leaves least, if one earns its place."""
    state, taken = found.state, {effect.law for effect in found.laws}
    motor = dict(zip(predictor.joints, torque, strict=True))
    effects = [
        effect_of(law, ends[law], motor[law.joint])
        for law in laws(predictor, found.residual, ends)
        if law not in taken
    ]
    screen, at = few(draft, max(SCREENED))
    answers = responses(screen, state.layout, state.u, effects)
    left = found.residual[at]
    fits = [
        fit(a, left, fitted[at], chosen[at], penalty(e), e.law.kind not in SIGNED)
        for e, a in zip(effects, answers, strict=True)
    ]
    ranked = sorted(range(len(effects)), key=lambda i: fits[i].chosen)
    if not found.ceilings:
        found.ceilings = [
            Ceiling(effects[i].law, float(np.sqrt(fits[i].chosen)), False) for i in ranked
        ]
    if np.sqrt(fits[ranked[0]].chosen) > (1 - LEAST_IMPROVEMENT) * rms(left[chosen[at]]):
        return False
    short = _shortlist(effects, fits, ranked, rms(left[chosen[at]]))
    states = [_with(state, effects[i], fits[i], predictor.joints) for i in short]
    # the coarser simulation serves for changes only: what it is off by at first is taken from it
    shift = off(draft, state, found.residual)[fitted]
    begin_at_the_best(states, draft, fitted, [effects[i] for i in short], shift)
    # what the model has moves along, by derivatives that all its new companions share
    given = columns(state, draft, fitted)
    fits = refit(states, draft, fitted, shift=shift, given=given)
    residuals, errors = _left(states, predictor, chosen)
    near = [i for i, e in enumerate(errors) if e <= NEAR * min(errors)]
    if not near:
        return False
    short, states = [short[i] for i in near], [states[i] for i in near]
    finish(states, [fits[i] for i in near], predictor, fitted)
    residuals, errors = _left(states, predictor, chosen)
    if not found.laws:
        known = {effects[i].law: error for i, error in zip(short, errors, strict=True)}
        found.ceilings = sorted(
            (
                Ceiling(c.law, known[c.law], True) if c.law in known else c
                for c in found.ceilings
            ),
            key=lambda c: c.rmse_rad,
        )  # fmt: skip
    block = blocks(predictor.samples.recording[chosen], predictor.samples.time[chosen])
    best = _simplest([effects[i].law for i in short], residuals, errors, chosen, block)
    if not earns_its_place(found.residual[chosen], residuals[best][chosen], block):
        return False
    _put(found, predictor, states[best], residuals[best], errors[best])
    law, finer = effects[short[best]].law, 2
    while _still_more(found) and may_be_finer(law):
        effect = effect_of(law, ends[law], motor[law.joint], finer)
        if not _take_finer(found, effect, predictor, draft, fitted, chosen, block, given):
            break
        finer *= 2
    return True


def earns_its_place(before: np.ndarray, after: np.ndarray, block: np.ndarray) -> bool:
    """Whether residuals fall by more than chance, and by enough to matter, from `before`.

    Args:
        before, after: (n,) rad, on the same samples.
        block: (n,) the block of time of each.
    """
    gain = improvement(before, after, block, np.random.default_rng(SEED))
    return gain.lower > 0 and gain.fraction >= LEAST_IMPROVEMENT


def _put(
    found: Search, predictor: Predictor, state: State, residual: np.ndarray, error: float
) -> None:
    found.state, found.residual, found.rmse_rad = state, residual, error
    found.noise_floor_rad = min(
        found.noise_floor_rad,
        noise_floor(list(predictor.recordings), predictor.samples.by_row(residual)),
    )


def _still_more(found: Search) -> bool:
    return found.rmse_rad > AT_THE_FLOOR * found.noise_floor_rad


def _take_finer(
    found: Search,
    finer: SplineTorque,
    predictor: Predictor,
    draft: Predictor,
    fitted: np.ndarray,
    chosen: np.ndarray,
    block: np.ndarray,
    given: Mapping[tuple, np.ndarray],
) -> bool:
    """Give the law that was taken last more knots, if they earn their place."""
    state = found.state
    *before, (coarse, _) = state.laws
    curve = coarse.basis @ state.u[weights_in(state.layout, coarse)]
    bare = without(state, [coarse.name])
    layout, u = joined(bare.layout, bare.u, [term_of(finer, predictor.joints)])
    weights = np.linalg.lstsq(finer.basis, curve, rcond=None)[0]
    u[weights_in(layout, finer)] = weights
    screen, at = few(draft, max(SCREENED))
    (answer,) = responses(screen, layout, u, [finer])
    target = found.residual[at] + answer @ weights
    guess = fit(answer, target, fitted[at], chosen[at], penalty(finer))
    u[weights_in(layout, finer)] = guess.weights
    grown = State(layout, u, (*before, (finer, guess.penalty)))
    finish([grown], refit([grown], draft, fitted, 0, given=given), predictor, fitted)
    (residual,), (error,) = _left([grown], predictor, chosen)
    if not earns_its_place(found.residual[chosen], residual[chosen], block):
        return False
    _put(found, predictor, grown, residual, error)
    return True


def _shortlist(
    effects: Sequence[SplineTorque], fits: Sequence[Fit], ranked: list[int], baseline: float
) -> list[int]:
    """The laws that promise most, and of the simplest those that promise nearly as much."""
    least = fits[ranked[0]].chosen
    # where all leave much the same, what counts is how much they take away
    enough = baseline**2 - HALF * (baseline**2 - least)
    ranked = [i for i in ranked if fits[i].chosen <= enough]
    short = [i for i in ranked if fits[i].chosen <= PROMISING**2 * least][:LEADERS]
    simple = [i for i in ranked if order(effects[i].law) <= 1 and i not in short]
    return short + [i for i in simple if fits[i].chosen <= PROMISING**4 * least][:2]


def _left(
    states: Sequence[State], predictor: Predictor, chosen: np.ndarray
) -> tuple[list[np.ndarray], list[float]]:
    """Residuals (nsample,) of states, and their RMS on the choosing samples."""
    requests = [Request(s.layout, s.u[None]) for s in states]
    residuals = [predictor.samples.q - q[0] for q in predictor.predict(requests)]
    return residuals, [rms(np.nan_to_num(r[chosen], nan=np.inf)) for r in residuals]


def _with(state: State, effect: SplineTorque, guess, joints: tuple[str, ...]) -> State:
    layout, u = joined(state.layout, state.u, [term_of(effect, joints)])
    u[weights_in(layout, effect)] = guess.weights
    return State(layout, u, (*state.laws, (effect, guess.penalty)))


def _simplest(taken: Sequence[Law], residuals, errors, chosen, block) -> int:
    """The best; or a simpler law that it does not beat."""
    best = int(np.argmin(errors))
    for i in sorted(range(len(taken)), key=lambda i: (order(taken[i]), errors[i])):
        if order(taken[i]) >= order(taken[best]) or not np.isfinite(errors[i]):
            continue
        rng = np.random.default_rng(SEED)
        gain = improvement(residuals[i][chosen], residuals[best][chosen], block, rng)
        if gain.lower <= 0 or gain.fraction <= ALIKE:
            return i
    return best
