"""Torques that follow two joints at once, as cables, belts, shared weights and linkages make them.

What has the potential V(q_i + r q_j) pulls on joint i with f = −V' and on joint j with r f. So what
two joints lack at a time tells r, whatever the curve is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.diagnose.conditions import Series
from t2l.diagnose.explained_variance import by_bins
from t2l.diagnose.inverse_dynamics_residual import derivatives
from t2l.effects.law import Law
from t2l.identify.block_bootstrap import blocks
from t2l.identify.prediction import Predictor
from t2l.recordings.splits import LEAST_TO_HOLD_OUT_WHOLE

# numerics: where the fit of a ratio begins, a factor of 1.4 apart; beyond, it acts on one joint
RATIOS = (sizes := 5.0 ** np.linspace(-1, 1, 11), -sizes)


@dataclass(frozen=True)
class Lever:
    """How much of what two joints lack a tendon tells, at its best ratio.

    Attributes:
        square: of the missing torque, in parts of what makes a difference.
    """

    ratio: float
    square: float


def lever(predictor: Predictor, law: Law, missing: np.ndarray, size: tuple[float, float]) -> Lever:
    """The best of `RATIOS` for a tendon.

    Args:
        missing: (nsample,) N·m.
        size: N·m that makes a difference on its two joints.
    """
    samples = predictor.samples
    x = samples.q if law.follows == "position" else derivatives(Series(samples), samples.q)[1]
    here, there = paired(predictor, law, x)
    (lack, its), block = paired(predictor, law, missing), _blocks(predictor, law)
    found = [Lever(0.0, 0.0)]
    for ratio in np.concatenate(RATIOS):
        parts = size[0] ** -2, (ratio / size[1]) ** 2
        tension = (parts[0] * lack + parts[1] * its / ratio) / sum(parts)
        told = by_bins(tension, here + ratio * there, block)
        found.append(Lever(float(ratio), told * np.var(tension) * sum(parts)))
    return max(found, key=lambda one: one.square)


def reach(
    predictor: Predictor, law: Law, ratio: float, values: Sequence[np.ndarray]
) -> tuple[float, float]:
    """Of what a tendon follows, over several (nsample,) of its variable of each joint."""
    pairs = [paired(predictor, law, one) for one in values]
    x = np.concatenate([here + ratio * there for here, there in pairs])
    return float(x.min()), float(x.max())


def paired(predictor: Predictor, law: Law, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (nsample,) of a law's joint, and of the other, at the times at which both have one."""
    joints = [predictor.joints.index(name) for name in (law.joint, law.of)]
    both = np.concatenate([rows[:, joints] for rows in predictor.samples.by_row(values)])
    return tuple(both[np.isfinite(both).all(axis=1)].T)


def _blocks(predictor: Predictor, law: Law) -> np.ndarray:
    """What is left out in turn: recordings, or blocks of time where they are few."""
    samples = predictor.samples
    recording, _ = paired(predictor, law, samples.recording.astype(float))
    if len(predictor.recordings) >= LEAST_TO_HOLD_OUT_WHOLE:
        return recording.astype(int)
    return blocks(recording.astype(int), paired(predictor, law, samples.time)[0])
