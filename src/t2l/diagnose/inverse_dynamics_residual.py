"""The torque a model lacks, read off its position error without naming any effect.

A torque δτ beyond the model's moves a position-controlled joint by δq, such that

    δτ = M δq̈ + (Kd + d) δq̇ + Kp δq + δg

with the joint's own inertia M, the MJCF's damping d, gains that include those of a soft hold to the
measurement (`t2l.identify.soft_hold`), and the change δg of the gravity load where
nothing compensates it; coupling between joints is left out. So friction appears as a step in the
direction of motion and a payload as the gravity load, at every gain alike, where the position
error itself only shows them through the loop.
"""

import numpy as np

from t2l.diagnose.conditions import Series
from t2l.diagnose.settings import FASTEST_HZ
from t2l.identify.prediction import Predictor
from t2l.identify.scales import gravity_torque, joint_inertia

# derived: to each side of a sample, of the parabola that gives derivatives: half a period in all
WINDOW_S = 1 / (4 * FASTEST_HZ)
LEAST_NEIGHBOURS = 2  # numerics: to each side: a parabola through five samples averages noise


def missing_torque(predictor: Predictor, residual: np.ndarray) -> np.ndarray:
    """Torque (nsample,) N·m that the joints feel beyond the model's.

    Args:
        residual: (nsample,) measured minus predicted position, rad.
    """
    samples = predictor.samples
    kp, kd = (np.array([getattr(r, key) for r in predictor.recordings]) for key in ("kp", "kd"))
    at = samples.recording, samples.joint
    position, velocity, acceleration = derivatives(Series(samples), residual)
    model = predictor.model()
    damping = model.dof_damping[[model.joint(name).dofadr[0] for name in predictor.joints]]
    on = samples.of([r.powered for r in predictor.recordings])
    hold_kp, hold_kd = (0 * kp, 0 * kd) if predictor.holding is None else predictor.holding
    missing = (on * kp[at] + hold_kp[at]) * position
    back_emf = np.array([r.back_emf for r in predictor.recordings])
    missing += (on * (kd + back_emf)[at] + hold_kd[at] + damping[samples.joint]) * velocity
    missing += joint_inertia(predictor)[samples.joint] * acceleration
    carried = np.array([bool(r.gravity_compensation) for r in predictor.recordings])
    hanging = 1.0 - carried[samples.recording] * on
    if hanging.any():
        gravity = gravity_torque(predictor)
        missing += hanging * (gravity - gravity_torque(predictor, samples.q - residual))
    return missing


def derivatives(series: Series, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, first and second derivative of a parabola through the neighbours of each sample.

    Savitzky and Golay, Smoothing and differentiation of data by simplified least squares
    procedures, 1964. All are (nsample,), as `values`.
    """
    # not scipy.signal.savgol_filter: it does the same, but takes longer to import than to compare
    ordered = values[series.order]
    fitted = np.empty((3, len(values)))
    for part in series.parts():
        period = np.median(np.diff(series.time[part])) if part.stop - part.start > 1 else 1.0
        half = max(LEAST_NEIGHBOURS, round(WINDOW_S / period))
        offsets = np.arange(-half, half + 1) * period
        to_parabola = np.linalg.pinv(np.stack([offsets**0, offsets, offsets**2 / 2], axis=1))
        padded = np.pad(ordered[part], half, mode="edge")
        windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
        fitted[:, series.order[part]] = to_parabola @ windows.T
    return tuple(fitted)
