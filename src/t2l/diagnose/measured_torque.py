"""Where torque was measured: whether the drive or the machine is not what the model says.

Along the measured motion the log's law says what torque the drive gives, and inverse dynamics of
the robot's file what torque the motion takes. The measured torque lies between the two. What it
differs by from the law is the drive's: gains, delays, torque constant. What it differs by from the
inverse dynamics is the machine's: friction, masses. Neither takes effects of a model file into
account.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import mujoco
import numpy as np

from t2l.diagnose.conditions import Series
from t2l.effects.effect import AT_REST_RAD_S
from t2l.identify.drive_torque import drive_torque
from t2l.identify.prediction import Predictor
from t2l.identify.scales import gravity_torque

LEAST_ROWS = 50  # statistics: fewer tell no gain
# tuned: of the measured torque's RMS, below which two torques agree: accelerations of a swing at
# 200 rows a second leave 0.07
SMALL = 0.1
CLEARLY = 2.0  # tuned: times as far as the other, where one side is to blame


@dataclass(frozen=True)
class TorqueSides:
    """Of one joint over all recordings.

    Attributes:
        rows: how many were compared.
        measured_rms: N·m, of the measured torque about its mean.
        drive_rms, machine_rms: N·m, of what it differs by from the law and from inverse dynamics.
        drive_share, machine_share: of the variance of the measured torque that each explains.
        kp_factor, kd_factor: real over logged gains by least squares of the measured torque on the
            law's terms; NaN where a gain is zero or the drive agrees.
    """

    joint: str
    rows: int
    measured_rms: float
    drive_rms: float
    machine_rms: float
    drive_share: float
    machine_share: float
    kp_factor: float
    kd_factor: float

    @property
    def side(self) -> str:
        """Where the error lies: ``neither``, ``drive``, ``machine`` or ``both``."""
        drive, machine = self.drive_rms, self.machine_rms
        if max(drive, machine) < SMALL * self.measured_rms:
            return "neither"
        if drive > CLEARLY * machine:
            return "drive"
        return "machine" if machine > CLEARLY * drive else "both"

    @property
    def sentence(self) -> str:
        """What was found, for people."""
        said = {
            "neither": "the drive and the robot's file both agree with it",
            "drive": "the error lies in the drive: gains, delay or torque constant",
            "machine": "the error lies in the machine: friction, masses or inertia",
            "both": "the error lies on both sides, or the measured torque is off itself",
        }[self.side]
        gains = " and ".join(
            f"{name} {factor:.2f}"
            for name, factor in (("Kp", self.kp_factor), ("Kd", self.kd_factor))
            if np.isfinite(factor)
        )
        gains = f"; by regression, real over logged gains: {gains}" if gains else ""
        return (
            f"Measured torque of {self.joint} ({self.measured_rms:.3g} N·m RMS): the law is off by "
            f"{self.drive_rms:.2g} N·m ({self.drive_share:.0%} of the variance explained), inverse "
            f"dynamics by {self.machine_rms:.2g} ({self.machine_share:.0%}): {said}{gains}."
        )

    def plain(self) -> dict[str, Any]:
        """For JSON: None for what is not known."""
        numbers = {k: v if v == v else None for k, v in asdict(self).items()}
        return {**numbers, "side": self.side, "sentence": self.sentence}


def torque_sides(predictor: Predictor) -> list[TorqueSides]:
    """Of each joint whose torque was measured often enough while it moved."""
    samples, recordings = predictor.samples, predictor.recordings
    if all(r.tau is None for r in recordings):
        return []
    absent = [np.full_like(r.q, np.nan) if r.tau is None else r.tau for r in recordings]
    tau = samples.of(absent)
    q, dq, ddq = _smooth(predictor)
    gravity = gravity_torque(predictor)
    compensated = np.array([bool(r.gravity_compensation) for r in recordings])[samples.recording]
    with_it = drive_torque(predictor, q, dq, gravity)
    without = drive_torque(predictor, q, dq, 0 * gravity)
    takes = _inverse_dynamics(predictor, q, dq, ddq)
    kp, kd = (np.array([getattr(r, k) for r in recordings]) for k in ("kp", "kd"))
    at = samples.recording, samples.joint
    stiff = kp[at] * (samples.of([r.q_des for r in recordings]) - q)
    damped = -kd[at] * dq
    lasting = _around(predictor, tau, kp[at] * dq + kd[at] * ddq)
    on = samples.of([r.powered for r in recordings]) == 1
    found = []
    for j, joint in enumerate(predictor.joints):
        rows = (samples.joint == j) & np.isfinite(tau + lasting + takes) & on
        if rows.sum() < LEAST_ROWS or np.std(tau[rows]) == 0:
            continue
        # a log's torque may or may not hold the compensation: what is nearer to the law counts
        bare = compensated & (
            _rms((tau - without)[rows & compensated]) < _rms((tau - with_it)[rows & compensated])
        )
        law = np.where(bare, without, with_it)
        needed = np.where(bare, takes - gravity, takes)
        off = (tau - law)[rows], (lasting - needed)[rows]
        size = float(np.std(tau[rows]))
        one = TorqueSides(
            joint, int(rows.sum()), size, _rms(off[0]), _rms(off[1]),
            *(1 - float(np.var(error)) / size**2 for error in off), np.nan, np.nan,
        )  # fmt: skip
        found.append(_with_gains(one, tau[rows], law[rows], stiff[rows], damped[rows]))
    return found


def _around(predictor: Predictor, tau: np.ndarray, falls: np.ndarray) -> np.ndarray:
    """Mean torque (nsample,) from the row before to the row after.

    A command that is held falls behind the joint until the next one: a torque that was measured
    with the command is the tip of a saw tooth, which the motion does not follow.

    Args:
        falls: N·m/s, of the loop's torque while the command is held.
    """
    series, found = Series(predictor.samples), np.empty_like(tau)
    for part in series.parts():
        at = series.order[part]
        step = np.diff(predictor.samples.time[at], append=np.nan)
        mean = tau[at] - falls[at] * step / 2
        found[at] = (mean + np.append(np.nan, mean[:-1])) / 2
    return found


def _smooth(predictor: Predictor) -> np.ndarray:
    """Position and its derivatives (3, nsample) along a smoothing spline of each joint.

    How smooth it is, its own samples say (generalised cross-validation: Craven and Wahba, 1979).
    """
    from scipy.interpolate import make_smoothing_spline  # slow to import, and few logs have torque

    samples, series = predictor.samples, Series(predictor.samples)
    found = np.zeros((3, len(samples)))
    for part in series.parts():
        at = series.order[part]
        # a joint that stands still has nothing to be smoothed
        if len(at) < LEAST_ROWS or np.ptp(samples.q[at]) == 0:
            found[0, at] = samples.q[at]
            continue
        spline = make_smoothing_spline(samples.time[at], samples.q[at])
        found[:, at] = [spline(samples.time[at], nu) for nu in range(3)]
    return found


def _with_gains(one: TorqueSides, tau, law, stiff, damped) -> TorqueSides:
    """With the gains that the measured torque asks for, where the drive does not agree."""
    if one.side not in ("drive", "both"):
        return one
    terms = [term for term in (stiff, damped) if term.any()]
    rest = law - sum(terms, np.zeros_like(law))
    basis = np.column_stack([*terms, np.ones_like(law)])
    factors = iter(np.linalg.lstsq(basis, tau - rest, rcond=None)[0])
    kp, kd = (float(next(factors)) if term.any() else np.nan for term in (stiff, damped))
    return TorqueSides(**{**asdict(one), "kp_factor": kp, "kd_factor": kd})


def _inverse_dynamics(predictor: Predictor, q, dq, ddq) -> np.ndarray:
    """N·m (nsample,) that motions take of the robot's file; NaN where a joint was not sampled."""
    model, samples = predictor.model(), predictor.samples
    data, mass, bias = mujoco.MjData(model), np.zeros((model.nv, model.nv)), np.empty(model.nv)
    places = [model.joint(name).qposadr[0] for name in predictor.joints]
    dofs = [model.joint(name).dofadr[0] for name in predictor.joints]
    damping, friction = model.dof_damping[dofs], model.dof_frictionloss[dofs]
    signals = []
    for at, speed, rate in zip(*(samples.by_row(x) for x in (q, dq, ddq)), strict=True):
        takes = np.full_like(at, np.nan)
        for row in np.flatnonzero(np.isfinite(at).all(axis=1)):
            data.qpos[places], data.qvel[dofs] = at[row], speed[row]
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fullM(model, data, mass)
            mujoco.mj_fwdVelocity(model, data)
            mujoco.mj_rne(model, data, 0, bias)
            takes[row] = mass[np.ix_(dofs, dofs)] @ rate[row] + bias[dofs]
        takes += damping * speed + friction * np.tanh(speed / AT_REST_RAD_S)
        signals.append(takes)
    return samples.of(signals)


def _rms(values: Sequence[float] | np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else np.inf
