"""Whether an effect has drifted: the rule, and what it is applied to.

An effect has drifted if both hold:

1. the interval of one of its parameters on the new log lies outside the adopted value's own
   interval: that of a refit to the old logs, or the value alone where none are given;
2. with the effect held at its adopted values, and all others refitted, the error on the new log is
   at least `LEAST_CHANGE` larger.

Intervals hold for all parameters together at 95 % (Bonferroni), so that a machine that has not
changed is called drifted once in twenty checks at most. The second condition keeps a change that is
certain and without consequence from counting. An effect of which no parameter is determined by the
new log cannot be told.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from t2l.identify.levels import MATERIAL
from t2l.identify.refit import Refit
from t2l.identify.uncertainty import Uncertainty

LEVEL = 0.05  # statistics: the customary one
# derived: of the error: what t2l diagnose asks of an effect before it is adopted
LEAST_CHANGE = MATERIAL
DRIFTED, UNCHANGED, UNTOLD = "drifted", "unchanged", "cannot be told"
RULE = (
    "drifted: an interval on the new log (95 % for all parameters together) lies outside the "
    "adopted value's own, and holding the effect at its adopted values makes the error at least "
    f"{100 * LEAST_CHANGE:.0f} % larger"
)


@dataclass(frozen=True)
class Change:
    """One parameter of one joint: `adopted` and `found` are values with their intervals."""

    parameter: str
    unit: str
    joint: str | None
    adopted: float
    adopted_interval: tuple[float, float]
    found: float
    interval: tuple[float, float]
    outside: bool
    determined: bool


@dataclass(frozen=True)
class EffectVerdict:
    """Of one effect; `error_if_held` is relative to the refitted error, minus one."""

    effect: str
    verdict: str
    error_if_held: float
    changes: tuple[Change, ...]


def verdicts(
    new: Refit, joints: Sequence[str], reference: Refit | None = None
) -> list[EffectVerdict]:
    """Judge each effect of a model.

    Args:
        new: refit to the new log, with each effect held in turn.
        reference: refit to the logs that the model was made from.
    """
    layout = new.layout
    z = float(norm.ppf(1 - LEVEL / (2 * max(len(layout), 1))))
    unexcited = set(new.found.unexcited())
    found = []
    for effect in dict.fromkeys(slot.term.effect.name for slot in layout.slots):
        changes = [
            _change(new, reference, i, z, joints, i not in unexcited)
            for i, slot in enumerate(layout.slots)
            if slot.term.effect.name == effect and not layout.rough[i]
        ]
        held = new.held.get(effect, new.after) / max(new.after, 1e-30) - 1
        certain = any(change.outside and change.determined for change in changes)
        verdict = UNCHANGED
        if not any(change.determined for change in changes):
            verdict = UNTOLD
        elif certain and held >= LEAST_CHANGE:
            verdict = DRIFTED
        found.append(EffectVerdict(effect, verdict, float(held), tuple(changes)))
    return found


def _change(new: Refit, reference: Refit | None, i: int, z: float, joints, determined) -> Change:
    layout, slot = new.layout, new.layout.slots[i]
    here = _ends(new.found, i, z)
    own = (new.adopted[i], new.adopted[i])
    if reference is not None:
        own = _ends(reference.found, i, z)
        # an adopted value that the old logs put elsewhere is not thereby changed
        own = min(own[0], new.adopted[i]), max(own[1], new.adopted[i])
    theta = [float(np.exp(x) if layout.log[i] else x) for x in (*own, *here)]
    return Change(
        parameter=slot.parameter.name,
        unit=slot.parameter.unit,
        joint=None if slot.joint is None else joints[slot.joint],
        adopted=float(layout.theta(new.adopted)[i]),
        adopted_interval=(theta[0], theta[1]),
        found=float(layout.theta(new.found.u)[i]),
        interval=(theta[2], theta[3]),
        outside=bool(here[0] > own[1] or here[1] < own[0]),
        determined=bool(determined),
    )


def _ends(found: Uncertainty, i: int, z: float) -> tuple[float, float]:
    error = found.error[i] if np.isfinite(found.error[i]) else 1e3
    return float(found.u[i] - z * error), float(found.u[i] + z * error)
