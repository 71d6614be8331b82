"""The torque that drives give by the log: its commands, gains and motors, at given states."""

import numpy as np

from t2l.identify.prediction import Predictor


def drive_torque(
    predictor: Predictor, q: np.ndarray, dq: np.ndarray, gravity: np.ndarray
) -> np.ndarray:
    """N·m (nsample,) by the law of every recording.

    Args:
        q, dq: (nsample,) rad and rad/s, of the joint of each sample.
        gravity: (nsample,) N·m, what holds the arm still, for loops that compensate it.
    """
    samples, recordings = predictor.samples, predictor.recordings
    at = samples.recording, samples.joint
    kp, kd, stall, back_emf = (
        np.array([getattr(r, key) for r in recordings])[at]
        for key in ("kp", "kd", "stall", "back_emf")
    )
    torque = kp * (samples.of([r.q_des for r in recordings]) - q)
    torque -= kd * dq
    torque += samples.of([r.feed_forward for r in recordings])
    compensated = np.array([bool(r.gravity_compensation) for r in recordings])
    torque += np.where(compensated[samples.recording], gravity, 0.0)
    torque = np.clip(torque, -stall, stall) * samples.of([r.supply for r in recordings])
    torque -= back_emf * dq
    return torque * samples.of([r.powered for r in recordings])
