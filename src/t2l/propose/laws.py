"""Which laws a missing torque may follow, and over what range the recordings show each."""

from collections.abc import Mapping

import numpy as np

from t2l.diagnose.conditions import Series, features
from t2l.diagnose.inverse_dynamics_residual import derivatives
from t2l.effects.law import ALLOWED, FRICTION, HYSTERESIS, OTHERS, TORQUE, Law
from t2l.identify.prediction import Predictor

MOVES = 1e-9  # in the variable's unit; less is no motion
LEAST_SHARE = 0.03  # of the squared error; a joint with less has no law of its own


def laws(predictor: Predictor, residual: np.ndarray, ranges: Mapping[Law, tuple]) -> list[Law]:
    """Laws on joints that hold some of the error, simplest first.

    Args:
        residual: (nsample,) rad.
        ranges: as `ranges` gives them.
    """
    square = np.bincount(predictor.samples.joint, residual**2, len(predictor.joints))
    shown = square >= LEAST_SHARE * square.sum()
    joints = {name for name, share in zip(predictor.joints, shown, strict=True) if share}
    return [law for law in ranges if law.joint in joints]


def ranges(predictor: Predictor, q: np.ndarray, dq: np.ndarray) -> dict[Law, tuple[float, float]]:
    """Every law whose variable the recordings vary, with its range, measured and predicted.

    Args:
        q, dq: (nsample,) predicted position and velocity.
    """
    samples = predictor.samples
    measured_dq = derivatives(Series(samples), samples.q)[1]
    both = [features(predictor, q, dq), features(predictor, samples.q, measured_dq)]
    # of time there is only one
    source = {"commanded torque": "torque", "load": "gravity"}
    found: dict[Law, tuple[float, float]] = {}

    def seen(variable: str, joint: int) -> tuple[float, float]:
        at = samples.joint == joint
        values = np.concatenate([f[source.get(variable, variable)][at] for f in both])
        return float(values.min()), float(values.max())

    def span(variable: str, joint: int) -> tuple[float, float]:
        if variable == "constant":
            return 0.0, 1.0
        if variable == "distance":
            return 0.0, float(np.ptp(seen("position", joint)))
        if variable in ("speed", "commanded torque size"):
            low, high = seen("velocity" if variable == "speed" else "commanded torque", joint)
            return 0.0, max(abs(low), abs(high))
        return seen(variable, joint)

    for kind, variables in ALLOWED.items():
        for variable in variables:
            for joint, name in enumerate(predictor.joints):
                found[Law(kind, name, variable, name)] = span(variable, joint)
    for variable in OTHERS:
        for joint, name in enumerate(predictor.joints):
            for other, its in enumerate(predictor.joints):
                if other != joint:
                    found[Law(TORQUE, name, variable, its)] = span(variable, other)
    return {law: ends for law, ends in found.items() if ends[1] - ends[0] > MOVES}


def order(law: Law) -> int:
    """How many forms a law may take: of laws that explain alike, the lower comes first."""
    if law.follows == "constant":
        return 0
    if law.of != law.joint:
        return 4
    return {
        (TORQUE, "time"): 5,
        (FRICTION, "time"): 5,
        (HYSTERESIS, "distance"): 3,
        (TORQUE, "position"): 1,
        (TORQUE, "velocity"): 1,
    }.get((law.kind, law.follows), 2)
