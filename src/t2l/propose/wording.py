"""A proposal in sentences."""

import numpy as np

from t2l.effects.law import PHASE, TENDON, Curve
from t2l.identify.levels import MATERIAL, TIED
from t2l.names import listed
from t2l.propose.proposal import LAW, NOTHING, Proposal

# derived: of the way that a curve goes up and down, its ends differ by: what it goes back is little
MONOTONE = 1 - 2 * MATERIAL


def told(curve: Curve) -> str:
    """A law with what its curve does: "a torque on elbow that grows with its position"."""
    law = curve.law
    if law.follows == PHASE:
        return f"{law.words} every {curve.at[-1] - curve.at[0]:.3g} s"
    if law.kind == TENDON:
        return f"{law.words} ({variable(curve)})"
    if law.follows == "constant":
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


def headline(proposal: Proposal) -> str:
    """What was found, in a sentence."""
    floor = f"{1e3 * proposal.noise_floor_rad:.3g} mrad"
    before = proposal.report_baseline_rad or proposal.choice_baseline_rad
    after = proposal.report_rmse_rad or proposal.choice_rmse_rad
    where = "unseen recordings" if proposal.report_rmse_rad else "what was left out"
    if proposal.verdict == LAW:
        laws = listed([told(one.curve) for one in proposal.learned])
        if not after < before:
            return (
                f"{laws[0].upper()}{laws[1:]} would explain what is left in what was left out of "
                f"its fits, but not on {where}: there the error grows from {1e3 * before:.3g} to "
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


def _in_mrad(*errors_rad: float) -> list[str]:
    return [f"{1e3 * error:.3g}" for error in errors_rad]
