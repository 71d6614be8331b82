"""The measured motion of recordings at the ticks of their control loops, with its derivatives.

It is the motion that the model predicts plus a smooth curve through what it misses. So what the
commands do at a tick stays sharp, and the noise of an encoder is not differentiated: only the
residual is smoothed, by a quintic spline whose knots are as far apart as its own samples ask for
(generalised cross-validation: Craven and Wahba, Smoothing noisy data with spline functions, 1979).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_lsq_spline

from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor
from t2l.identify.schedules import Group
from t2l.identify.simulation import hermite

KNOTS_S = (0.5, 0.25, 0.12, 0.06, 0.03, 0.015)  # numerics: distances that are tried
DEGREE = 5  # numerics: acceleration is a smooth curve too
LEAST_SAMPLES = 3  # numerics: a knot interval


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
                more[:, :, r, j], noise[r, j] = _smooth(clock[rows], residual[rows], at)
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


def _smooth(
    clock: np.ndarray, values: np.ndarray, at: np.ndarray
) -> tuple[Sequence[np.ndarray], float]:
    """Value and derivative of a smooth curve, and what the latter is off by."""
    best, least, chosen = None, np.inf, 0.0
    for distance in KNOTS_S:
        inner = _knots(clock, distance)
        if inner is None:
            continue
        knots = np.r_[(clock[0],) * (DEGREE + 1), inner, (clock[-1],) * (DEGREE + 1)]
        try:
            spline = make_lsq_spline(clock, values, knots, k=DEGREE)
        except (ValueError, np.linalg.LinAlgError):
            continue
        free = len(values) - len(knots) + DEGREE + 1
        if free < 1:
            continue
        left = np.sum((values - spline(clock)) ** 2) / free**2 * len(values)
        if left < 0.98 * least:  # numerics: fewer knots where more say the same
            best, least, chosen = spline, left, distance
    if best is None:
        flat = np.interp(at, clock, values)
        return (flat, np.zeros_like(flat)), 0.0
    inside = np.clip(at, clock[0], clock[-1])
    period = np.median(np.diff(clock)) if len(clock) > 1 else 1.0
    # of a straight line through the samples of an interval
    count = max(chosen / period, 1.0)
    # derived: of the slope of a line through equally spaced samples
    noise = np.sqrt(12 * least / count) / chosen
    still = at != inside
    value, slope = best(inside), best(inside, 1)
    slope[still] = 0.0
    return (value, slope), float(noise)


def _knots(clock: np.ndarray, distance: float) -> np.ndarray | None:
    """Inner knots about so far apart, each with samples enough between; None if there are few."""
    span = clock[-1] - clock[0]
    count = int(span / distance)
    if len(clock) < LEAST_SAMPLES * max(count, 1) + 2 * DEGREE:
        return None
    if count < 2:
        return np.zeros(0)
    wanted = np.linspace(clock[0], clock[-1], count + 1)[1:-1]
    # a gap in the samples has no knots
    samples = np.searchsorted(clock, wanted)
    kept, last = [], 0
    for knot, place in zip(wanted, samples, strict=True):
        if place - last >= LEAST_SAMPLES and len(clock) - place >= LEAST_SAMPLES:
            kept.append(knot)
            last = place
    return np.array(kept)
