"""What an error follows: the conditions from which its missing torque could be foretold."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.findings import percent
from t2l.diagnose.inverse_dynamics_residual import missing_torque
from t2l.diagnose.oscillation import swing
from t2l.identify.block_bootstrap import blocks
from t2l.identify.levels import HALF, MATERIAL
from t2l.identify.prediction import Predictor
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE

LEAST = MATERIAL  # of the missing torque; a condition that tells less is not listed
LEAST_SWING = HALF  # likewise: of many frequencies, one tells a little by chance
FREEDOM = MATERIAL  # that bins must explain more than proportion does: they take any form
SWING_FREEDOM = 3 * FREEDOM  # derived: likewise, for an amplitude, a phase and a frequency
NO_BINS = ("velocity squared", "constant")  # others have the same bins

PHRASES = {
    "direction": "the direction of motion",
    "velocity": "the velocity",
    "velocity squared": "the square of the velocity",
    "acceleration": "the acceleration",
    "torque": "the commanded torque",
    "torque rate": "the rate of change of the commanded torque",
    "gravity": "the gravity load",
    "load": "the direction of motion times the commanded torque",
    "position": "the position",
    "command velocity": "the velocity of the command",
    "time": "the time since the start",
}


@dataclass(frozen=True)
class ExplainedVariance:
    """A condition, and how much of the missing torque it tells.

    Attributes:
        condition: one of `t2l.diagnose.conditions.CONDITIONS`.
        fraction: of the missing torque that the condition foretells in recordings (or blocks of
            time) left out of the estimate, over all joints.
        proportional: whether in proportion, and as a fraction of the square; otherwise as a mean
            per bin of the condition, and as a fraction of the variance.
        joints: the same fraction for each joint.
        frequency_hz: of the swing, where the condition is a swing in time.
    """

    condition: str
    fraction: float
    proportional: bool
    joints: dict[str, float]
    frequency_hz: float | None = None

    @property
    def freedom(self) -> float:
        """What it has to tell more than a proportion does, for the forms it may take."""
        if self.frequency_hz is not None:
            return SWING_FREEDOM
        return 0.0 if self.proportional else FREEDOM

    @property
    def sentence(self) -> str:
        """For people."""
        joint, most = max(self.joints.items(), key=lambda item: item[1])
        where = f" (most on {joint}, {percent(most)})" if len(self.joints) > 1 else ""
        if self.condition == "constant":
            return f"{percent(self.fraction)} of the missing torque is constant{where}"
        if self.frequency_hz is not None:
            return (
                f"{percent(self.fraction)} of the missing torque swings at "
                f"{self.frequency_hz:.2g} Hz in time, which the commands do not{where}"
            )
        return (
            f"{percent(self.fraction)} of the missing torque follows "
            f"{PHRASES[self.condition]}{where}"
        )


def explained_variance(
    predictor: Predictor,
    residual: np.ndarray,
    features: Mapping[str, np.ndarray],
    missing: np.ndarray | None = None,
) -> list[ExplainedVariance]:
    """Conditions that foretell some of the missing torque, the one that tells most first.

    Each joint counts as much as its part of the squared position error.

    Args:
        residual: (nsample,) measured minus predicted position, rad.
        features: as `t2l.diagnose.conditions.features` gives them.
        missing: (nsample,) N·m, where `missing_torque(predictor, residual)` is known already.
    """
    samples = predictor.samples
    if missing is None:
        missing = missing_torque(predictor, residual)
    held = [np.flatnonzero(samples.joint == j) for j in range(len(predictor.joints))]
    weight = np.array([np.sum(residual[at] ** 2) for at in held])
    weight /= weight.sum() or 1.0
    block = left_out_in_turn(samples.recording, samples.time)
    found = []
    for condition, values in features.items():
        told = {
            True: np.array([proportion(missing[at], values[at], block[at]) for at in held]),
            False: np.array([by_bins(missing[at], values[at], block[at]) for at in held]),
        }
        proportional = condition in NO_BINS or bool(
            weight @ told[True] >= weight @ told[False] - FREEDOM
        )
        fractions = told[proportional]
        if weight @ fractions < LEAST:
            continue
        found.append(
            ExplainedVariance(
                condition,
                float(weight @ fractions),
                proportional,
                dict(zip(predictor.joints, fractions.tolist(), strict=True)),
            )
        )
    found += _swinging(predictor, missing, held, weight)
    return sorted(found, key=lambda f: f.freedom - f.fraction)


def _swinging(predictor: Predictor, missing, held, weight) -> list[ExplainedVariance]:
    """A swing of the joint that matters most, told of all joints."""
    samples = predictor.samples
    command = predictor.samples.of([r.q_des for r in predictor.recordings])
    swings = [swing(missing[i], command[i], samples.time[i], samples.recording[i]) for i in held]
    frequency = swings[int(np.argmax(weight * [fraction for _, fraction in swings]))][0]
    # other joints count as far as they swing alike; a log tells no finer what does
    alike = [abs(f - frequency) * samples.time.max() < 1 for f, _ in swings]
    fractions = np.array([x if same else 0.0 for (_, x), same in zip(swings, alike, strict=True)])
    if weight @ fractions < LEAST_SWING:
        return []
    joints = dict(zip(predictor.joints, fractions.tolist(), strict=True))
    return [ExplainedVariance("time", float(weight @ fractions), False, joints, frequency)]


def left_out_in_turn(recording: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(n,) which part of the data each belongs to: its recording, or of few a block of time."""
    enough = recording.max(initial=-1) + 1 >= LEAST_TO_HOLD_OUT_WHOLE
    return recording if enough else blocks(recording, time)


def proportion(values: np.ndarray, condition: np.ndarray, block: np.ndarray) -> float:
    """Fraction of values² (n,) that a multiple of the condition tells in blocks left out."""
    x = condition / (np.sqrt(np.mean(condition**2)) + 1e-300)
    xx, xy = np.bincount(block, x * x), np.bincount(block, x * values)
    factor = (xy.sum() - xy) / np.maximum(xx.sum() - xx, 1e-9)
    return _told(values, factor[block] * x)


def by_bins(values: np.ndarray, condition: np.ndarray, block: np.ndarray) -> float:
    """Fraction of the variance that means per bin of the condition tell in blocks left out.

    A condition that only repeats the mean of the values (n,) tells nothing. Bins hold equally many
    samples, and there are as many as n asks for (Sturges, The choice of a class interval, 1926).
    """
    levels, bins = np.unique(condition), 1 + int(np.ceil(np.log2(len(condition))))
    if len(levels) > bins:
        levels = np.unique(np.quantile(condition, np.linspace(0, 1, bins + 1)[:-1]))
    bin = np.maximum(np.searchsorted(levels, condition, side="right") - 1, 0)
    shape = (block.max() + 1, len(levels))
    cell = block * len(levels) + bin
    sums = np.bincount(cell, values, np.prod(shape)).reshape(shape)
    counts = np.bincount(cell, minlength=np.prod(shape)).reshape(shape)
    means = (sums.sum(axis=0) - sums) / np.maximum(counts.sum(axis=0) - counts, 1)
    rest, others = sums.sum() - sums.sum(axis=1), counts.sum() - counts.sum(axis=1)
    mean = rest / np.maximum(others, 1)
    return _told(values, means[block, bin], mean[block])


def _told(values: np.ndarray, foretold: np.ndarray, otherwise: np.ndarray | float = 0.0) -> float:
    whole = np.sum((values - otherwise) ** 2)
    left = np.sum((values - foretold) ** 2)
    return float(max(0.0, 1 - left / whole)) if whole > 0 else 0.0
