"""A diagnosis as sentences and as JSON."""

from typing import Any

import numpy as np

from t2l.diagnose import confounded
from t2l.diagnose.candidate import LEAST_IMPROVEMENT, Candidate
from t2l.diagnose.ranking import MISSING, NEAR_THE_FLOOR, NOTHING_MISSING, Diagnosis
from t2l.identify.block_bootstrap import Improvement
from t2l.names import listed, with_minus


def headline(diagnosis: Diagnosis) -> str:
    """What was found, in a sentence."""
    if diagnosis.verdict != MISSING:
        errors = diagnosis.test_rmse_rad, diagnosis.validation_rmse_rad
        return ended(diagnosis.verdict, *errors, diagnosis.noise_floor_rad)
    error, floor = 1e3 * diagnosis.test_rmse_rad, 1e3 * diagnosis.noise_floor_rad
    best = diagnosis.ranking[0]
    titles = titles_of(diagnosis)
    others = listed([titles[name] for name in best.tied_with])
    tied = f", tied with {others}" if others else ""
    uncertain = " (uncertain)" if best.certain is False else ""
    if best.confounded:
        what = best.confounded.from_what(titles)
        uncertain = f" (uncertain: these recordings cannot tell it from {what})"
    after = "grows without bound"
    if best.test_rmse_rad is not None:
        after = f"goes from {error:.3g} to {1e3 * best.test_rmse_rad:.3g} mrad"
    return (
        f"The model lacks {best.effect.title}{uncertain}{tied}: with it the test error {after} "
        f"(noise {floor:.3g} mrad)."
    )


def ended(
    verdict: str, test_rmse_rad: float, validation_rmse_rad: float, noise_floor_rad: float
) -> str:
    """Likewise, where no effect is missing or none explains the error."""
    error, floor = 1e3 * test_rmse_rad, 1e3 * noise_floor_rad
    if verdict != NOTHING_MISSING:
        return (
            f"Unexplained: the test error of {error:.3g} mrad is {error / floor:.1f} times the "
            f"noise ({floor:.3g} mrad), and no known effect removes it."
        )
    if test_rmse_rad > NEAR_THE_FLOOR * validation_rmse_rad:
        return (
            "No effect is missing in what was fitted and chosen by, but the test error is "
            f"{error:.3g} mrad (noise {floor:.3g} mrad): the test recordings show something "
            "that the others do not. Fit to some like them too."
        )
    return (
        f"No effect is missing: the test error of {error:.3g} mrad is what measurement "
        f"noise and quantisation leave ({floor:.3g} mrad)."
    )


def titles_of(diagnosis: Diagnosis) -> dict[str, str]:
    """What reports call the effects of a ranking, by name."""
    return {candidate.effect.name: candidate.effect.title for candidate in diagnosis.ranking}


def why(candidate: Candidate, correlations: dict[str, float], titles: dict[str, str]) -> str:
    """Why an effect is, or is not, believed.

    Args:
        correlations: by joint, of the error before and the condition that the effect follows.
        titles: of the effects that it was tried with, by name.
    """
    effect, gain = candidate.effect, candidate.improvement
    if not candidate.simulated:
        return (
            f"{effect.title}: by the linear model of the loop the error on what is left out "
            f"{change(gain)}; others promise more, so it was not simulated."
        )
    if not candidate.justified:
        return (
            f"{effect.title} does not earn its place: with it the error on what is left out "
            f"{change(gain)}."
        )
    seen = ""
    if correlations and effect.follows:
        joint = max(correlations, key=lambda name: abs(correlations[name]))
        seen = (
            f" On {joint} the missing torque correlates with {effect.follows} by "
            f"{with_minus(f'{correlations[joint]:+.2f}')}."
        )
    return (
        f"{effect.signature[0].upper()}{effect.signature[1:]}.{seen} With {effect.title} "
        f"the error on what is left out falls by {100 * gain.fraction:.0f} % "
        f"({100 * gain.ci95[0]:.0f} to {100 * gain.ci95[1]:.0f} %). "
        f"{chosen(candidate, titles)}"
    )


def chosen(candidate: Candidate, titles: dict[str, str]) -> str:
    """How often it is selected, and what it is not told from, in a sentence."""
    if candidate.confounded:
        what = candidate.confounded.from_what(titles)
        return f"But these recordings cannot tell it from {what}."
    if candidate.chosen_share is None:
        return ""
    sure = "" if candidate.certain else ", less than half: this is uncertain"
    return f"It is chosen in {100 * candidate.chosen_share:.0f} % of the resamples{sure}."


def as_json(diagnosis: Diagnosis, extra: dict[str, Any]) -> dict[str, Any]:
    """The diagnosis as `diagnosis.json` holds it; `extra` comes at its end."""
    return {
        "verdict": diagnosis.verdict,
        "sentence": headline(diagnosis),
        "noise_floor_rad": diagnosis.noise_floor_rad,
        "baseline": {
            "train_rmse_q_rad": diagnosis.train_rmse_rad,
            "validation_rmse_q_rad": diagnosis.validation_rmse_rad,
            "test_rmse_q_rad": diagnosis.test_rmse_rad,
        },
        "ranking": [_candidate(c, diagnosis.joints) for c in diagnosis.ranking],
        **extra,
    }


def _candidate(candidate: Candidate, joints: tuple[str, ...]) -> dict[str, Any]:
    effect, layout = candidate.effect, candidate.layout
    found, theta = candidate.uncertainty, layout.theta(candidate.u)
    parameters = {}
    for i, slot in enumerate(layout.slots):
        if slot.term.effect.name != effect.name:
            continue
        name = slot.parameter.name
        key = name if slot.joint is None else f"{joints[slot.joint]}.{name}"
        parameters[key] = {
            "value": float(theta[i]),
            "ci95": list(found.interval(i)) if found and np.isfinite(found.error[i]) else None,
            "unit": slot.parameter.unit,
            "meaning": slot.parameter.meaning,
        }
    return {
        "effect": effect.name,
        "title": effect.title,
        "joints": [joints[j] for j in candidate.term.joints],
        "validation_rmse_q_rad": candidate.validation_rmse_rad,
        "test_rmse_q_rad": candidate.test_rmse_rad,
        "train_rmse_q_rad": candidate.train_rmse_rad,
        "improvement": {
            "fraction": candidate.improvement.fraction,
            "ci95": list(candidate.improvement.ci95),
        },
        "justified": candidate.justified,
        "chosen_share": candidate.chosen_share,
        "certain": candidate.certain,
        "confounded": confounded.as_json(filter(None, [candidate.confounded])),
        "parameters": parameters,
        "tied_with": candidate.tied_with,
        "simulated": candidate.simulated,
        "why": candidate.why,
        "notes": notes(candidate, joints),
    }


def notes(candidate: Candidate, joints: tuple[str, ...]) -> list[str]:
    """What the data cannot tell about the candidate's parameters."""
    found = candidate.uncertainty
    if found is None:
        return []
    slots = candidate.layout.slots

    def name(i: int) -> str:
        slot = slots[i]
        where = "" if slot.joint is None else f" of {joints[slot.joint]}"
        return f"{slot.term.effect.title}: {slot.parameter.name}{where}"

    sentences = [
        f"The data hardly determine {name(i)}: nothing in them excites it."
        for i in found.unexcited()
        if not candidate.layout.rough[i]
    ]
    sentences += [
        f"The data determine only a combination of {name(i)} and {name(j)}."
        for i, j in found.inseparable()
    ]
    layout = candidate.layout
    at_bound = (candidate.u <= layout.lower) | (candidate.u >= layout.upper)
    sentences += [
        f"{name(i)} ends on its bound, {layout.theta(candidate.u)[i]:.4g} "
        f"{slots[i].parameter.unit}."
        for i in np.flatnonzero(at_bound & ~layout.rough)
        if slots[i].lower != 0
    ]
    return sentences


def change(gain: Improvement) -> str:
    """How the error changes, with its interval, in words: falls by 26 % (2 to 50 %)."""
    sign = 1 if gain.fraction >= 0 else -1
    by, *ends = (f"{100 * sign * part:.0f}" for part in (gain.fraction, *gain.ci95[::sign]))
    low, high = map(with_minus, ends)
    much = gain.fraction >= LEAST_IMPROVEMENT
    unsure = ", too unsure to be adopted" if much and gain.lower <= 0 else ""
    return f"{'falls' if sign > 0 else 'grows'} by {by} % ({low} to {high} %){unsure}"
