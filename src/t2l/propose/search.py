"""Laws taken one after the other: the one that leaves least where it was neither fitted nor chosen.

A round simulates the response to every law's basis functions at the present model, which makes the
best curve of each law a linear fit, on some samples, with a penalty that others choose. The laws
that promise most are fitted through the simulation, and the one that leaves least on the choosing
samples is taken; of laws that a paired block bootstrap there cannot tell from it, the simplest. It
stays if the bootstrap finds that it earns its place, or it goes half of the way to the noise, alone
or with one or two more.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from t2l.diagnose.conditions import features
from t2l.diagnose.judging import rms
from t2l.diagnose.settings import MOST_EFFECTS, SCREENED
from t2l.effects.law import LIMIT, SIGNED, TENDON, Law
from t2l.effects.spline_torque import SplineTorque
from t2l.identify.fitting import LEADERS
from t2l.identify.levels import AT_THE_FLOOR, HALF, PROMISING
from t2l.identify.model import Model
from t2l.identify.noise_floor import noise_floor
from t2l.identify.prediction import Predictor, Request, check_finite
from t2l.identify.progress import Progress, pieces
from t2l.identify.scales import sized
from t2l.propose.bases import SIZE, effect_of, penalty, straight, tendon_of
from t2l.propose.decision import each_goes_half_way
from t2l.propose.dictionary import responses
from t2l.propose.found import (
    LEAST_IMPROVEMENT,
    Ceiling,
    Search,
    earns_its_place,
    explain_alike,
)
from t2l.propose.knots import Finer, refine
from t2l.propose.laws import laws, lines, order, ranges
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.limits import begun, limit_of
from t2l.propose.partial_regression import PartialRegression
from t2l.propose.refit import (
    State,
    begin_at_the_best,
    coarser,
    columns,
    finish,
    off,
    refit,
    with_law,
)
from t2l.propose.ridge import Fit, fit
from t2l.propose.simplify import simplify
from t2l.propose.smoothing import smooth_again
from t2l.propose.split import few
from t2l.propose.tendons import BETWEEN, measured, reach, table

NEAR = AT_THE_FLOOR  # times the least error after them: laws that are fitted to the end
MOST_LAWS = MOST_EFFECTS  # more is a model that fits anything
# derived: laws that wait for another: a heavier link lacks weight, inertia and friction, of which
# the first shows alone and the rest may only together
AHEAD = 2


def search(
    model: Model,
    samples: LearningSamples,
    progress: Progress = lambda what, fraction: None,
) -> Search:
    """Laws that explain what `model` leaves of the recordings.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    predictor = samples.predictor
    model = sized(model, predictor)
    layout, u = model.vector(predictor.joints)
    state = State(layout, u)
    request = Request(layout, u[None])
    (q,), (dq,) = predictor.predict([request], velocity=True)
    check_finite(q[0], predictor, request)
    left = predictor.samples.q - q[0]
    baseline = rms(left[samples.chosen])
    floor = noise_floor(list(predictor.recordings), predictor.samples.by_row(left))
    ends = ranges(predictor, q[0], dq[0], samples.others)
    found = Search(state, baseline, baseline, floor, left)
    motor = dict(zip(predictor.joints, model.sizes.torque, strict=True))
    commanded = features(predictor, q[0], dq[0])["torque"]
    only_lines = lines(predictor)
    variables = measured(predictor)
    both = {
        "position": (variables["position"], table(predictor, q[0])),
        "velocity": (variables["velocity"], table(predictor, dq[0])),
    }

    def made(law: Law, finer: int = 1, ratio: float = 0.0) -> SplineTorque:
        if law.kind == LIMIT:
            at = predictor.samples.joint == predictor.joints.index(law.joint)
            return limit_of(law, commanded[at], dq[0][at], SIZE * motor[law.joint])
        if law.kind == TENDON:
            pair = [predictor.joints.index(name) for name in (law.joint, law.of)]
            x = [one[:, pair] for one in both[law.follows]]
            # the ratio may still move to the next
            near = (reach(x, ratio * times) for times in (1.0, 1 / BETWEEN, BETWEEN))
            return tendon_of(law, [*near], motor[law.joint], ratio)
        effect = effect_of(law, ends[law], motor[law.joint], finer)
        return straight(effect) if law in only_lines else effect

    draft = coarser(predictor, state)
    earned, seen, rounds = replace(found), [set()], 0
    curves = pieces(progress)
    while len(found.laws) < MOST_LAWS:
        # one that leaves only noise would not be worth taking, with those that wait for it
        worth = earned.is_material(found.noise_floor_rad)
        if not (worth and found.left_more_than_noise):
            break
        next(curves)(f"learning curve {len(found.laws) + 1}", 0.0)
        taken = _take_one(found, samples, draft, ends, made, [*motor.values()])
        if taken is None:
            break
        before, limit = found.state, NEAR * max(found.rmse_rad, found.noise_floor_rad)
        simplify(found, limit, samples, draft)
        there = {effect.law for effect in found.laws}
        if there in seen:
            break
        seen.append(there)
        # no worse with less needs no proof that chance could not have done it
        less = found.rmse_rad <= earned.rmse_rad and len(found.state.u) < len(earned.state.u)
        ahead = max(len(found.laws) - len(earned.laws), 1)
        # what goes so far is no chance, though all that it explains be one moment
        far = each_goes_half_way(ahead, found.rmse_rad, earned.rmse_rad, found.noise_floor_rad)
        more = earned.is_material(found.rmse_rad) and (
            far or earns_its_place(earned.residual, found.residual, samples)
        )
        if less or more:
            if found.state is before:
                refine(found, taken.finer, samples, draft, taken.given)
            earned, rounds = replace(found), 0
            continue
        rounds += 1
        # a curve in whose place two constants came is still one law
        if min(rounds, len(found.laws) - len(earned.laws)) > AHEAD:
            break
    earned.ceilings = found.ceilings
    if earned.left_more_than_noise:
        smooth_again(earned, samples, draft)
    return earned


@dataclass(frozen=True)
class Taken:
    """The law that was taken last.

    Attributes:
        given: derivatives by what the model had before.
    """

    finer: Finer
    given: dict[tuple, np.ndarray]


def _take_one(
    found: Search,
    samples: LearningSamples,
    draft: Predictor,
    ends: Mapping[Law, tuple[float, ...]],
    made: Callable[..., SplineTorque],
    spent: Sequence[float],
) -> Taken | None:
    """Add the law that leaves least; None if none leaves less than before by enough to matter.

    Args:
        draft: with coarser ticks, for all but the last steps of a fit.
        ends: of the variable of each law.
        made: the effect of a law, with so many times its knots, and a ratio.
        spent: (njoint,) N·m, of the motors.
    """
    predictor, fitted, chosen = samples.predictor, samples.fitted, samples.chosen
    state, taken = found.state, {effect.law for effect in found.laws}
    free = {law: end for law, end in ends.items() if law not in taken}
    candidates = laws(predictor, found.residual, free, spent)
    effects = [made(law, ratio=ratio) for law, ratio in candidates.items()]
    screen, at = few(draft, max(SCREENED))
    answers = responses(screen, state.layout, state.u, effects)
    left = found.residual[at]
    # what the model has moves along, by derivatives that all its new companions share
    given = columns(state, draft, np.ones(len(fitted), bool))
    others = PartialRegression.at(state, {key: c[at] for key, c in given.items()}, fitted[at])
    target, masks = others.left_of(left), others.masks(chosen[at])
    beside = [others.left_of_responses(a) for a in answers]
    fits = [_guess(e, a, target, *masks) for e, a in zip(effects, beside, strict=True)]
    ranked = sorted(range(len(effects)), key=lambda i: fits[i].chosen)
    if not found.ceilings:
        found.ceilings = [
            Ceiling(effects[i].law, float(np.sqrt(fits[i].chosen)), False) for i in ranked
        ]
    if np.sqrt(fits[ranked[0]].chosen) > (1 - LEAST_IMPROVEMENT) * rms(left[chosen[at]]):
        return None
    short = _shortlist(effects, fits, ranked, rms(left[chosen[at]]))
    # what the model has stands still at first, so that no part that two curves share runs away
    alone = (_guess(effects[i], answers[i], left, fitted[at], chosen[at]) for i in short)
    states = [
        with_law(state, effects[i], first.weights, fits[i].penalty, predictor.joints)
        for i, first in zip(short, alone, strict=True)
    ]
    # the coarser simulation serves for changes only: what it is off by at first is taken from it
    shift = off(draft, state, found.residual)[fitted]
    begin_at_the_best(states, draft, fitted, [effects[i] for i in short], shift)
    given = {key: column[fitted] for key, column in given.items()}
    fits = refit(states, draft, fitted, shift=shift, given=given)
    residuals, errors = samples.left_by(states)
    near = [i for i, e in enumerate(errors) if e <= NEAR * min(errors)]
    if not near:
        return None
    short, states = [short[i] for i in near], [states[i] for i in near]
    drafts = [replace(state, u=state.u.copy()) for state in states]
    finish(states, [fits[i] for i in near], predictor, fitted)
    finished, after = samples.left_by(states)
    # derivatives of the draft may lead astray where laws hardly differ
    for k, i in enumerate(near):
        if after[k] > errors[i]:
            states[k], finished[k], after[k] = drafts[k], residuals[i], errors[i]
    residuals, errors = finished, after
    if not found.laws:
        known = {effects[i].law: error for i, error in zip(short, errors, strict=True)}
        found.ceilings = sorted(
            (
                Ceiling(c.law, known[c.law], True) if c.law in known else c
                for c in found.ceilings
            ),
            key=lambda c: c.rmse_rad,
        )  # fmt: skip
    best = _simplest([effects[i].law for i in short], residuals, errors, samples)
    if errors[best] > (1 - LEAST_IMPROVEMENT) * found.rmse_rad:
        return None
    found.put(predictor, states[best], residuals[best], errors[best])
    law = effects[short[best]].law
    return Taken(partial(made, law), given)


def _guess(
    effect: SplineTorque,
    answers: np.ndarray,
    target: np.ndarray,
    fitted: np.ndarray,
    chosen: np.ndarray,
) -> Fit:
    """Weights of a law that its responses, as `t2l.propose.dictionary.responses`, promise most."""
    if effect.atoms is not None:
        return begun(effect, answers, target, fitted, chosen)
    positive = effect.law.kind not in SIGNED
    return fit(answers, target, fitted, chosen, penalty(effect), positive)


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
    simple.sort(key=lambda i: order(effects[i].law))
    return short + [i for i in simple if fits[i].chosen <= PROMISING**4 * least][:2]


def _simplest(
    taken: Sequence[Law],
    residuals: Sequence[np.ndarray],
    errors: Sequence[float],
    samples: LearningSamples,
) -> int:
    """The best; or a simpler law that it does not beat."""
    best = int(np.argmin(errors))
    for i in sorted(range(len(taken)), key=lambda i: (order(taken[i]), errors[i])):
        if order(taken[i]) >= order(taken[best]) or not np.isfinite(errors[i]):
            continue
        if explain_alike(residuals[i], residuals[best], samples):
            return i
    return best
