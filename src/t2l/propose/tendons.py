"""Torques that follow two joints at once, as cables, belts, shared weights and linkages make them.

What has the potential V(q_i + r q_j) pulls on joint i with f = −V' and on joint j with r f. So what
two joints lack at a time tells r, whatever the curve is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.conditions import Series
from t2l.diagnose.explained_variance import by_bins, left_out_in_turn
from t2l.diagnose.inverse_dynamics_residual import derivatives, missing_torque
from t2l.effects.law import TENDON, Law
from t2l.identify.prediction import Predictor

# numerics: where the fit of a ratio begins; beyond, it acts on one joint
RATIOS = np.outer((1, -1), 5.0 ** np.linspace(-1, 1, 11)).ravel()
BETWEEN = 5.0**0.2  # derived: of one ratio and the next


@dataclass(frozen=True)
class Lever:
    """How much of what two joints lack a tendon tells, at its best ratio.

    Attributes:
        square: of the missing torque, in parts of what the motors spend. Zero tells nothing.
    """

    ratio: float
    square: float


def lever(
    x: np.ndarray, missing: np.ndarray, block: np.ndarray, spent: tuple[float, float]
) -> Lever:
    """The best of `RATIOS` for a tendon.

    Args:
        x: (nrow, 2) its variable of each of its joints.
        missing: (nrow, 2) N·m.
        block: (nrow,) what is left out in turn.
        spent: N·m that the motors of the two spend.
    """
    found = [Lever(0.0, 0.0)]
    for ratio in RATIOS if len(x) else ():
        parts = spent[0] ** -2, (ratio / spent[1]) ** 2
        tension = (parts[0] * missing[:, 0] + parts[1] * missing[:, 1] / ratio) / sum(parts)
        told = by_bins(tension, x[:, 0] + ratio * x[:, 1], block)
        found.append(Lever(float(ratio), told * np.var(tension) * sum(parts)))
    return max(found, key=lambda one: one.square)


def levers(
    predictor: Predictor, residual: np.ndarray, laws: Sequence[Law], spent: Sequence[float]
) -> dict[Law, Lever]:
    """Of tendons that tell something of what is missing.

    Args:
        residual: (nsample,) measured minus predicted position, rad.
        spent: (njoint,) N·m.
    """
    if not laws:
        return {}
    series, joints = table(predictor, missing_torque(predictor, residual)), predictor.joints
    variables, recordings = measured(predictor), predictor.recordings
    number = np.repeat(np.arange(len(recordings)), [len(r.time) for r in recordings])
    block = left_out_in_turn(number, np.concatenate([r.time - r.time[0] for r in recordings]))
    found = {}
    for law in laws:
        pair = [joints.index(law.joint), joints.index(law.of)]
        x, missing = variables[law.follows][:, pair], series[:, pair]
        known = np.isfinite(x).all(axis=1)
        own = spent[pair[0]], spent[pair[1]]
        found[law] = lever(x[known], missing[known], block[known], own)
    return {law: one for law, one in found.items() if one.square > 0}


def best_of_each_joint(found: dict[Law, Lever]) -> dict[Law, Lever]:
    """Of the tendons of every joint the one over positions and the one over velocities."""
    best: dict[tuple[str, str], Law] = {}
    for law in sorted(found, key=lambda law: -found[law].square):
        for joint in (law.joint, law.of):
            best.setdefault((joint, law.follows), law)
    return {law: one for law, one in found.items() if law in best.values()}


def reach(x: Sequence[np.ndarray], ratio: float) -> tuple[float, float]:
    """Ends of what a tendon follows, over several (nrow, 2) of its variable of each joint."""
    ends = [np.nanquantile(one[:, 0] + ratio * one[:, 1], (0.0, 1.0)) for one in x]
    return float(np.min(ends)), float(np.max(ends))


def measured(predictor: Predictor) -> dict[str, np.ndarray]:
    """(nrow, njoint) measured, by what a tendon follows."""
    samples = predictor.samples
    velocity = derivatives(Series(samples), samples.q)[1]
    return {"position": table(predictor, samples.q), "velocity": table(predictor, velocity)}


def table(predictor: Predictor, values: np.ndarray) -> np.ndarray:
    """(nrow, njoint) values (nsample,) at every time of every recording.

    Between a joint's own samples they are interpolated. NaN of a joint that a recording lacks.
    """
    tables = predictor.samples.by_row(values)
    for recording, rows in zip(predictor.recordings, tables, strict=True):
        elapsed = recording.time - recording.time[0]
        for column, taken in zip(rows.T, recording.taken_s.T, strict=True):
            known = np.isfinite(column)
            if known.any():
                column[:] = np.interp(elapsed, taken[known], column[known])
    return np.concatenate(tables)


def pairs(joints: Sequence[str]) -> list[Law]:
    """Every tendon between two joints; each pair once, with the later joint first."""
    return [
        Law(TENDON, name, follows, before)
        for follows in ("position", "velocity")
        for j, name in enumerate(joints)
        for before in joints[:j]
    ]
