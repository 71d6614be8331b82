"""A proposal in sentences."""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import HYSTERESIS, PHASE, TENDON, Curve
from t2l.identify.levels import MATERIAL, TIED
from t2l.names import listed
from t2l.propose.decision import NEAR
from t2l.propose.proposal import LAW, NOTHING, Proposal
from t2l.propose.reconsider import Reconsidered

# derived: of the way that a curve goes up and down, its ends differ by: what it goes back is little
MONOTONE = 1 - 2 * MATERIAL
# format: of an explained part, and what it is called
FRACTIONS = ((0.29, 0.38, "a third"), (0.45, 0.55, "half"), (0.62, 0.71, "two thirds"))


def told(curve: Curve) -> str:
    """A law with what its curve does: "a torque on elbow that grows with its position"."""
    law = curve.law
    if law.follows == PHASE:
        return f"{law.words} every {curve.at[-1] - curve.at[0]:.3g} s"
    if law.kind == TENDON:
        return f"{law.words} ({variable(curve)})"
    if law.kind == HYSTERESIS or law.follows == "constant":
        return law.words
    change = np.diff(curve.torque)
    way, net = np.abs(change).sum(), change.sum()
    if abs(net) < MONOTONE * way:
        return law.words
    does = "grows with" if net > 0 else "falls with"
    return law.words.replace(" that follows ", f" that {does} ")


def variable(curve: Curve) -> str:
    """What a curve is drawn over: "position of elbow − 0.8 shoulder"."""
    law = curve.law
    if law.kind == TENDON:
        sign = "+" if curve.ratio > 0 else "−"
        return f"{law.follows} of {law.joint} {sign} {abs(curve.ratio):.3g} {law.of}"
    return law.follows


def part(fraction: float) -> str:
    """A part of something: "a third", or per cent."""
    for low, high, word in FRACTIONS:
        if low <= fraction <= high:
            return word
    return f"{100 * fraction:.0f} %"


def headline(proposal: Proposal) -> str:
    """What was found, in a sentence."""
    floor = f"{1e3 * proposal.noise_floor_rad:.3g} mrad"
    before = proposal.report_baseline_rad or proposal.choice_baseline_rad
    after = proposal.report_rmse_rad or proposal.choice_rmse_rad
    where = "unseen recordings" if proposal.report_rmse_rad else "the samples that chose"
    if proposal.verdict == LAW:
        laws = listed([told(one.curve) for one in proposal.learned])
        if not after < before:
            return (
                f"{laws[0].upper()}{laws[1:]} would explain what is left in the samples that chose "
                f"it, but not on {where}: there the error grows from {1e3 * before:.3g} to "
                f"{1e3 * after:.3g} mrad. So it is not what the model lacks."
            )
        return (
            f"The model lacks {laws}: with it the error on {where} falls from {1e3 * before:.3g} "
            f"to {1e3 * after:.3g} mrad (noise {floor})."
        )
    if proposal.verdict == NOTHING:
        return f"Nothing to propose: the error of {1e3 * before:.3g} mrad is noise ({floor})."
    return (
        f"No law of one variable explains the error of {1e3 * before:.3g} mrad (noise {floor}) on "
        "data that it was not fitted to."
    )


def as_formulas(proposal: Proposal, left_rad: float | None) -> str:
    """What formulas leave on unseen recordings, a sentence with a space before; "" if as much.

    Args:
        left_rad: with them in place of their curves; None without.
    """
    curves_rad = proposal.report_rmse_rad
    if left_rad is None or curves_rad is None or abs(left_rad / curves_rad - 1) <= TIED:
        return ""
    (left,) = _in_mrad(left_rad)
    if len(proposal.learned) == 1:
        return f" Its formula in place of the curve leaves {left} mrad."
    return f" Formulas in place of the curves that have one leave {left} mrad."


def retracted(found: Reconsidered) -> str:
    """What takes the place of names, beside what the names themselves leave on unseen data."""
    proposal = found.proposal
    names = listed(_titles(found.dropped, proposal))
    laws = listed([told(one.curve) for one in proposal.learned])
    came, known, learned, floor = _in_mrad(
        found.came_rmse_rad,
        proposal.report_baseline_rad,
        proposal.report_rmse_rad,
        proposal.noise_floor_rad,
    )
    said = (
        f"Unexplained by known effects. The model lacks {laws}. On unseen recordings the model as "
        f"it came leaves {came} mrad, with known effects {known}, and with what was learned in "
        f"place of {names} {learned} (noise {floor} mrad)."
    )
    verb = "explains" if len(found.dropped) == 1 else "explain"
    said = f"{said} {names[0].upper()}{names[1:]} {verb}"
    if found.decision is None:
        said = f"{said} about as much or less, and no more simply."
    else:
        explained = part(found.decision.fraction)
        said = f"{said} {explained} of the squared error, and would be a wrong name for it."
    enough = NEAR * max(proposal.report_baseline_rad, proposal.noise_floor_rad)
    if proposal.report_rmse_rad <= enough:
        return said
    return f"{said} But known effects leave less there: neither is all that the model lacks."


def part_of_it(found: Reconsidered) -> str:
    """Names that explain too little to be adopted, and what laws would explain."""
    proposal = found.proposal
    names = listed(_titles(found.partial, proposal))
    verb = "explains" if len(found.partial) == 1 else "explain"
    came, left, laws_left, floor = _in_mrad(
        found.came_rmse_rad,
        found.names_rmse_rad,
        proposal.report_rmse_rad,
        proposal.noise_floor_rad,
    )
    said = (
        f"Unexplained. {names[0].upper()}{names[1:]} {verb} only a part, {part(found.explained)} "
        f"of the squared error: {left} of {came} mrad are left on unseen recordings (noise {floor} "
        "mrad), so something else may look alike. The model stays as it came."
    )
    if proposal.verdict != LAW:
        return f"{said} No law of one variable holds on other data either.{_nearest(proposal)}"
    laws = listed([told(one.curve) for one in proposal.learned])
    share = max(0.0, 1 - (proposal.report_rmse_rad / found.came_rmse_rad) ** 2)
    verb, leave = ("explains", "leaves") if len(proposal.learned) == 1 else ("explain", "leave")
    return f"{said} Without names, {laws} {verb} {part(share)} and {leave} {laws_left} mrad."


def _titles(names: Sequence[str], proposal: Proposal) -> list[str]:
    """What reports call some effects."""
    known = proposal.model.known_effects()
    return [known[name].title if name in known else name for name in names]


def _in_mrad(*errors_rad: float) -> list[str]:
    return [f"{1e3 * error:.3g}" for error in errors_rad]


def _nearest(proposal: Proposal) -> str:
    """The law that would explain most of the samples that chose, although it does not hold."""
    if not proposal.ceilings or proposal.ceilings[0].rmse_rad >= proposal.choice_baseline_rad:
        return ""
    nearest = proposal.ceilings[0]
    share = 1 - (nearest.rmse_rad / proposal.choice_baseline_rad) ** 2
    return f" The nearest is {nearest.law.words}: {part(share)} of what it was chosen by."
