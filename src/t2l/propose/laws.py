"""Which laws a missing torque may follow, and over what range the recordings show each."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from t2l.diagnose.conditions import Series, features
from t2l.diagnose.inverse_dynamics_residual import derivatives, missing_torque
from t2l.effects.law import (
    ALLOWED,
    COLUMNS,
    GIVEN,
    INERTIA,
    PHASE,
    SESSION,
    TENDON,
    TORQUE,
    Law,
)
from t2l.effects.periodic_torque import strongest_frequency
from t2l.identify.levels import TIED
from t2l.identify.prediction import Predictor
from t2l.propose.bases import SMOOTH
from t2l.propose.tendons import best_of_each_joint, levers, pairs
from t2l.recordings.recording import Recording

SOURCE = {"commanded torque": "torque", "load": "gravity"}  # other names of what a law follows
# derived: at most, of a curve over what is logged: temperature and voltage act smoothly
INTERVALS = SMOOTH
MOVES = 1e-9  # numerics: in the variable's unit; less is no motion
SAME = 1e-2  # numerics: of a load's spread: a broken line over the position misses less of a sine
LEAST_SHARE = TIED  # of the squared error; a joint with less is not asked what it lacks


def laws(
    predictor: Predictor, residual: np.ndarray, ranges: Mapping[Law, tuple], spent: Sequence[float]
) -> dict[Law, float]:
    """Laws on joints that hold some of the error, simplest first; the ratio of tendons.

    Of the tendons of a joint those over the positions and over the velocities that tell most are
    tried.

    Args:
        residual: (nsample,) rad.
        ranges: as `ranges` gives them, of the laws that may be taken.
        spent: (njoint,) N·m, of the motors.
    """
    joints = {predictor.joints[joint] for joint in erring(predictor, residual)}
    own = {law: 0.0 for law in ranges if law.kind != TENDON and law.joint in joints}
    tendons = [law for law in ranges if law.kind == TENDON and {law.joint, law.of} & joints]
    found = best_of_each_joint(levers(predictor, residual, tendons, spent))
    return own | {law: one.ratio for law, one in found.items()}


def erring(predictor: Predictor, residual: np.ndarray) -> list[int]:
    """Joints that hold some of the squared error of a residual (nsample,), rad."""
    square = np.bincount(predictor.samples.joint, residual**2, len(predictor.joints))
    return [int(joint) for joint in np.flatnonzero(square >= LEAST_SHARE * square.sum())]


def ranges(
    predictor: Predictor, q: np.ndarray, dq: np.ndarray, others: Sequence[Recording] = ()
) -> dict[Law, tuple[float, ...]]:
    """Every law whose variable the recordings vary, with its range, measured and predicted.

    Between the ends of the range of what recordings tell are values at which it was seen. The time
    of the session is followed where the recordings follow one another by their clocks.

    Args:
        q, dq: (nsample,) predicted position and velocity.
        others: recordings that the laws must also predict: an optional column that one of all of
            them lacks is not followed.
    """
    samples = predictor.samples
    measured_dq = derivatives(Series(samples), samples.q)[1]
    logged = {
        variable: samples.of([r.held(column) for r in predictor.recordings])
        for variable, column in COLUMNS.items()
        if all(r.has(column) for r in (*predictor.recordings, *others))
    }
    clocks = [r.time[0] + r.taken_s for r in predictor.recordings]
    clock, missing = samples.of(clocks), missing_torque(predictor, samples.q - q)
    if _follow_one_another(predictor.recordings):
        logged[SESSION] = clock
    both = [features(predictor, q, dq), features(predictor, samples.q, measured_dq)]
    # of time, and of what is logged, there is only one
    found: dict[Law, tuple[float, ...]] = {}

    def period(at: np.ndarray) -> float:
        frequency = strongest_frequency(missing[at], clock[at])
        span = np.ptp(clock[at])
        # nothing comes again that is not seen twice
        return 1 / frequency if frequency * span >= 2 else 0.0

    def seen(variable: str, joint: int) -> tuple[float, float]:
        at = samples.joint == joint
        values = np.concatenate([f[SOURCE.get(variable, variable)][at] for f in both])
        return float(values.min()), float(values.max())

    def span(variable: str, joint: int) -> tuple[float, ...]:
        if variable in GIVEN:
            return _spread(logged[variable][samples.joint == joint])
        if variable == "constant":
            return 0.0, 1.0
        if variable == PHASE:
            begin = float(clock.min())
            return begin, begin + period(samples.joint == joint)
        if variable == "acceleration":
            # of what is measured it would be noise
            most = float(np.abs(both[0][variable][samples.joint == joint]).max())
            return -most, most
        if variable in ("speed", "commanded torque size"):
            low, high = seen("velocity" if variable == "speed" else "commanded torque", joint)
            return 0.0, max(abs(low), abs(high))
        return seen(variable, joint)

    for kind, variables in ALLOWED.items():
        if kind == TENDON:
            continue
        for variable in variables:
            if variable in GIVEN and variable not in logged:
                continue
            for joint, name in enumerate(predictor.joints):
                found[Law(kind, name, variable, name)] = span(variable, joint)
    for law in pairs(predictor.joints):
        # one joint that moves is enough
        pair = (predictor.joints.index(name) for name in (law.joint, law.of))
        found[law] = max((span(law.follows, joint) for joint in pair), key=np.ptp)
    return {law: ends for law, ends in found.items() if ends[-1] - ends[0] > MOVES}


def seen(predictors: Sequence[Predictor]) -> dict[Law, tuple[float, float]]:
    """Ends of what laws follow in recordings, as measured.

    Not of tendons, whose joints are at their ends at other times.
    """
    found: dict[Law, list[float]] = {}
    for predictor in dict.fromkeys(predictors):
        q = predictor.samples.q
        dq = derivatives(Series(predictor.samples), q)[1]
        for law, ends in ranges(predictor, q, dq).items():
            found.setdefault(law, []).extend(ends)
    return {law: (min(at), max(at)) for law, at in found.items() if law.kind != TENDON}


def lines(predictor: Predictor) -> set[Law]:
    """Laws that are straight lines only: over a load that follows from the joint's own position.

    A share of the load tells another mass. Every bend is one over the position.
    """
    samples = predictor.samples
    load = features(predictor, samples.q, derivatives(Series(samples), samples.q)[1])["gravity"]
    found = set()
    for joint, name in enumerate(predictor.joints):
        at = samples.joint == joint
        if _is_function(load[at], samples.q[at]):
            found.add(Law(TORQUE, name, "load", name))
    return found


def _is_function(load: np.ndarray, q: np.ndarray) -> bool:
    breaks = np.linspace(q.min(), q.max(), INTERVALS + 1)
    hats = np.stack([np.interp(q, breaks, one) for one in np.eye(len(breaks))], axis=1)
    left = load - hats @ np.linalg.lstsq(hats, load, rcond=None)[0]
    return bool(np.std(left) <= SAME * np.std(load))


def _follow_one_another(recordings: Sequence[Recording]) -> bool:
    """Whether there are several, and no two clocks show the same time."""
    spans = sorted((r.time[0], r.time[-1]) for r in recordings)
    return len(spans) > 1 and all(end < begin for (_, end), (begin, _) in pairwise(spans))


def _spread(values: np.ndarray) -> tuple[float, ...]:
    """Of equally spaced values over a range those near which something was seen."""
    low, high = values.min(), values.max()
    step = max(high - low, MOVES) / INTERVALS
    return tuple((low + step * np.unique(np.round((values - low) / step))).tolist())


def order(law: Law) -> int:
    """How many forms a law may take: of laws that explain alike, the lower comes first."""
    if law.follows == "constant" or law.kind == INERTIA:
        return 0
    if law.of != law.joint or law.column:
        return 4
    if law.follows in ("time", PHASE, SESSION):
        return 5
    return {
        (TORQUE, "position"): 1,
        (TORQUE, "velocity"): 1,
    }.get((law.kind, law.follows), 2)
