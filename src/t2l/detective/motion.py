"""The measured motion of recordings at the ticks of their control loops, with its derivatives.

It is the motion that the model predicts plus a curve through what it misses. So what the commands
do at a tick stays sharp. The curve is that of a torque which is held from tick to tick
(`t2l.detective.p_spline`), so that it follows what friction or a limit of the motor does at one.
"""

from dataclasses import dataclass, replace

import numpy as np

from t2l.detective.p_spline import p_spline
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.schedules import Group
from t2l.identify.simulation import hermite


@dataclass(frozen=True)
class Motion:
    """Of the recordings of a group, at its ticks; (ntick, nrec, njoint) each.

    Attributes:
        q, dq, ddq: measured, rad, rad/s and rad/s²; the last on average until the next tick.
        predicted, predicted_dq: as the model so far predicts them, rad and rad/s.
        noise_dq: (njoint,) rad/s, standard error of `dq`.
    """

    group: Group
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    predicted: np.ndarray
    predicted_dq: np.ndarray
    noise_dq: np.ndarray

    def foretold(self) -> "Motion":
        """As the model so far predicts it."""
        ddq = mean_ddq(self.predicted_dq, self.group.schedule.period_s)
        return replace(self, q=self.predicted, dq=self.predicted_dq, ddq=ddq)


def measured_motion(predictor: Predictor, layout: Layout, u: np.ndarray) -> list[Motion]:
    """The motion of every group of the predictor's recordings.

    Args:
        layout, u: the model so far, u (n,).
    """
    found = []
    for group, q, dq in predictor.at_ticks(layout, u):
        period = group.schedule.period_s
        recording, tick, rest, joint = group.wanted
        ticks = group.schedule.sample_ticks[tick]
        residual = predictor.samples.q[group.held] - at_samples(group, q, dq)
        clock = (ticks + rest) * period
        at = np.arange(len(q)) * period
        more, noise = np.zeros((2, *q.shape)), np.zeros(q.shape[1:])
        for r in range(q.shape[1]):
            for j in range(q.shape[2]):
                rows = np.flatnonzero((recording == r) & (joint == j))
                curve = p_spline(clock[rows], residual[rows], at)
                if curve is not None:
                    more[:, :, r, j] = curve.value, curve.slope
                    noise[r, j] = curve.slope_error
        moved = dq + more[1]
        found.append(
            Motion(
                group, q + more[0], moved, mean_ddq(moved, period), q, dq, np.median(noise, axis=0)
            )
        )
    return found


def mean_ddq(dq: np.ndarray, period_s: float) -> np.ndarray:
    """rad/s² from each tick to the next, of velocities (ntick, nrec, njoint)."""
    mean = np.diff(dq, axis=0) / period_s
    return np.concatenate([mean, mean[-1:]])


def at_samples(group: Group, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
    """Position (k,) at the samples of a group, of q and dq (ntick, nrec, njoint) at its ticks."""
    recording, tick, rest, joint = group.wanted
    ticks, period = group.schedule.sample_ticks[tick], group.schedule.period_s
    before, after = (ticks, recording, joint), (ticks + 1, recording, joint)
    return hermite(rest, period, q[before], q[after], dq[before], dq[after])
