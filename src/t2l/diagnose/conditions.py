"""Under which conditions the error arises: what physics cares about, at every sample."""

from itertools import pairwise

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S
from t2l.identify.drive_torque import drive_torque
from t2l.identify.prediction import Predictor
from t2l.identify.samples import Samples
from t2l.identify.scales import gravity_torque
from t2l.recordings.recording import Recording

UNITS = {
    "direction": "",
    "velocity": "rad/s",
    "velocity squared": "rad²/s²",
    "acceleration": "rad/s²",
    "torque": "N·m",
    "torque rate": "N·m/s",
    "gravity": "N·m",
    "load": "N·m",
    "position": "rad",
    "command velocity": "rad/s",
    "time": "s",
    "constant": "",
}
CONDITIONS = tuple(UNITS)
# what figures and menus call a condition, where its name alone does not say which torque it is
LABELS = {
    "torque": "commanded torque",
    "torque rate": "rate of the commanded torque",
    "gravity": "gravity load",
    "load": "direction × size of the commanded torque",
}


def features(predictor: Predictor, q: np.ndarray, dq: np.ndarray) -> dict[str, np.ndarray]:
    """Conditions at every sample of the recordings, as the model sees them; (nsample,) each.

    They come from the predicted motion: measured noise and the error itself stay out of them.

    Args:
        q, dq: (nsample,) predicted position and velocity, rad and rad/s.

    Returns:
        For each of `CONDITIONS` its values in `UNITS`. `velocity squared` is v|v|, `torque` the
        motor torque that the logged commands and gains ask for, gravity compensation included,
        and `load` its size with the sign of the velocity.
    """
    samples = predictor.samples
    series = Series(samples)
    gravity = gravity_torque(predictor)
    torque = drive_torque(predictor, q, dq, gravity)
    direction = np.where(np.abs(dq) > AT_REST_RAD_S, np.sign(dq), 0.0)
    return {
        "direction": direction,
        "velocity": dq,
        "velocity squared": dq * np.abs(dq),
        "acceleration": series.rate(dq),
        "torque": torque,
        "torque rate": series.rate(torque),
        "gravity": gravity,
        "load": direction * np.abs(torque),
        "position": q,
        "command velocity": predictor.samples.of(
            [_commanded_velocity(recording) for recording in predictor.recordings]
        ),
        "time": samples.time,
        "constant": np.ones(len(samples)),
    }


class Series:
    """Samples put in order of time within each joint of each recording."""

    def __init__(self, samples: Samples):
        self.order = np.lexsort((samples.time, samples.joint, samples.recording))
        self.time = samples.time[self.order]
        key = (samples.recording * (samples.joint.max() + 1) + samples.joint)[self.order]
        self.same = key[1:] == key[:-1]

    def parts(self) -> list[slice]:
        """The places in `order` that each series takes."""
        edges = [0, *(np.flatnonzero(~self.same) + 1), len(self.order)]
        return [slice(first, last) for first, last in pairwise(edges)]

    def rate(self, values: np.ndarray) -> np.ndarray:
        """Time derivative (nsample,) of values (nsample,), central inside a series."""
        # all series at once, which numpy.gradient cannot
        ordered = values[self.order]
        step = np.where(self.same, np.diff(self.time), 0.0)
        change = np.where(self.same, np.diff(ordered), 0.0)
        span = np.append(step, 0.0) + np.insert(step, 0, 0.0)
        total = np.append(change, 0.0) + np.insert(change, 0, 0.0)
        rate = np.empty_like(ordered)
        rate[self.order] = np.divide(total, span, out=np.zeros_like(total), where=span > 0)
        return rate


def _commanded_velocity(recording: Recording) -> np.ndarray:
    """(n, njoint) rad/s; zero where none is commanded."""
    if recording.drifts:
        return np.zeros_like(recording.q) if recording.dq_des is None else recording.dq_des
    return _command_velocity(recording.time, recording.q_des, 1 / recording.command_rate_hz)


def _command_velocity(time: np.ndarray, q_des: np.ndarray, period: float) -> np.ndarray:
    """Change of the command over its last period, (n, njoint) rad/s; zero at the start."""
    # numerics: stamps are rounded
    before = np.searchsorted(time, time - period + 1e-3 * period, side="right") - 1
    return np.where(before[:, None] >= 0, (q_des - q_des[np.maximum(before, 0)]) / period, 0.0)


def correlation(residual: np.ndarray, feature: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """Pearson's correlation of error and condition for each joint, (njoint,).

    It is zero where either does not vary, except that a condition that never varies is compared
    with the error's mean: mean over RMS, so that an error of constant size and sign gives ±1.

    Args:
        residual, feature, joint: (nsample,) error, condition and joint of every sample.
    """
    njoint = joint.max() + 1
    count = np.maximum(np.bincount(joint, minlength=njoint), 1)

    def mean(values):
        return np.bincount(joint, values, njoint) / count

    if np.ptp(feature) == 0:
        covariance, sizes = mean(residual), np.sqrt(mean(residual**2))
    else:
        x, y = residual - mean(residual)[joint], feature - mean(feature)[joint]
        covariance, sizes = mean(x * y), np.sqrt(mean(x**2) * mean(y**2))
    return np.divide(covariance, sizes, out=np.zeros(njoint), where=sizes > 1e-300)
