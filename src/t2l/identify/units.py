"""Numbers of recordings that cannot be in the units they are read in, asked about before a fit.

Each is a question with the numbers that raise it: what one machine cannot have another may.
"""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from t2l.recordings.recording import Recording
from t2l.robots import plant

ROWS = 2000  # numerics: of all recordings together
LEAST_ROWS = 10  # numerics: of each
# bound: of a joint without limits: two turns either way
MOST_RAD = 4 * np.pi
# tuned: of real machines, and of light joints that the model lacks friction of, at most 215
MOST_OVER_NEEDED = 500.0
# tuned: of real machines at most 21, of a servo that saturates in steps
MOST_OVER_LIMIT = 100.0
# tuned: of real machines that hold their own weight at least 0.18
LEAST_OVER_WEIGHT = 0.05
# bound: Kp h²/M; controllers are designed for 0.04 to 0.4 (Åström and Wittenmark, Computer-
# controlled systems, 1997, section 2.8), real machines here have up to 0.007
FASTEST = 1.0
# tuned: a rad/s is 57 deg/s; filters of velocity lose less than the rest
SPEED_FACTOR = 10.0
MOVES_RAD_S = 0.05  # numerics: RMS, below which velocity is noise


def questions(robot: str, recordings: Sequence[Recording]) -> list[str]:
    """What to ask whoever made the recordings, at most one sentence a joint and kind."""
    model = plant.compiled(plant.load(robot, recordings[0].joints), robot)
    rows = max(LEAST_ROWS, ROWS // len(recordings))
    asked: dict[tuple[str, str], str] = {}
    for recording in recordings:
        for joint, kind, sentence in _of(model, recording, rows):
            asked.setdefault((joint, kind), sentence)
    return list(asked.values())


def _of(
    model: mujoco.MjModel, recording: Recording, rows: int
) -> Iterator[tuple[str, str, str]]:
    known = np.flatnonzero(~np.isnan(recording.q).any(axis=1))
    if len(known) < LEAST_ROWS:
        return
    time, q, q_des = recording.time[known], recording.q[known], recording.q_des[known]
    dq = np.gradient(q, time, axis=0)
    few = np.unique(np.linspace(0, len(known) - 1, rows).astype(int))
    ddq = np.gradient(dq, time, axis=0)[few]
    needed, weight, inertia = _torques(model, recording.joints, q[few], dq[few], ddq)
    on = recording.powered[known][few] > 0
    given = np.where(on, recording.kp * (q_des - q)[few], 0.0)
    period = 1 / recording.control_rate_hz
    for j, name in enumerate(recording.joints):
        kp = f"{recording.name}: Kp {recording.kp[j]:g} N·m/rad on joint {name}"
        joint = model.joint(name)
        hinge = model.jnt_type[joint.id] == mujoco.mjtJoint.mjJNT_HINGE
        furthest = np.abs(q[:, j]).max()
        if hinge and MOST_RAD < furthest < np.rad2deg(2 * np.pi) and not model.jnt_limited[joint.id]:
            yield name, "degrees", (
                f"{recording.name}: q.{name} goes to {furthest:.3g}, {furthest / 2 / np.pi:.1f} "
                "turns if these are rad: are they degrees?"
            )
        fastest = np.sqrt(recording.kp[j] / inertia[:, j].min())
        if (fastest * period) ** 2 > FASTEST:
            yield name, "register", (
                f"{kp} gives a natural frequency of {fastest / 2 / np.pi:.0f} Hz, in a loop of "
                f"{recording.control_rate_hz:g} Hz (control_rate_hz): is it a register of the servo, "
                "is control_rate_hz the rate of the log, or does the model lack armature?"
            )
            continue
        torque, own = _rms(given[:, j]), _rms(needed[:, j]) + model.dof_frictionloss[joint.dofadr[0]]
        if torque > MOST_OVER_NEEDED * own:
            yield name, "register", (
                f"{kp} asks for {torque:.2g} N·m RMS, where its motion takes {own:.2g}: is it a "
                "register of the servo?"
            )
            continue
        low, high = model.jnt_actfrcrange[joint.id]
        limit = max(-low, high)
        if model.jnt_actfrclimited[joint.id] and torque > MOST_OVER_LIMIT * limit:
            yield name, "register", (
                f"{kp} asks for {torque:.2g} N·m RMS, where the robot's file allows {limit:.2g}: is "
                "it a register of the servo?"
            )
            continue
        carried = _rms(weight[:, j])
        follows = 0 < _rms((q_des - q)[few, j]) < np.ptp(q[:, j])
        if not recording.gravity_compensation and follows and torque < LEAST_OVER_WEIGHT * carried:
            yield name, "weight", (
                f"{kp} gives {torque:.2g} N·m RMS, where its weight takes {carried:.2g}: is Kp in "
                "N·m/deg, or is gravity_compensation true?"
            )
        if recording.dq is not None:
            yield from _speed(recording, name, recording.dq[known, j], dq[:, j])


def _speed(
    recording: Recording, name: str, measured: np.ndarray, of_q: np.ndarray
) -> Iterator[tuple[str, str, str]]:
    both = ~np.isnan(measured)
    measured, of_q = measured[both], of_q[both]
    if both.sum() < LEAST_ROWS or min(_rms(measured), _rms(of_q)) < MOVES_RAD_S:
        return
    # noise of positions is none of the velocities': it leaves this ratio as it is
    common = float(np.mean(measured * of_q))
    factor = float(np.mean(measured**2)) / common if common > 0 else np.inf
    if SPEED_FACTOR < factor < np.inf:
        yield name, "velocity", (
            f"{recording.name}: dq.{name} is {factor:.3g} times as fast as q.{name} changes: is it "
            "in deg/s?"
        )


def _torques(
    model: mujoco.MjModel, joints: Sequence[str], q: np.ndarray, dq: np.ndarray, ddq: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What motions take and weights take, N·m, and inertias, kg·m²; (nrow, njoint) each."""
    data = mujoco.MjData(model)
    at = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    needed, weight, inertia = np.empty((3, *q.shape))
    bias, mass = np.empty(model.nv), np.zeros((model.nv, model.nv))
    for i in range(len(q)):
        data.qpos[at], data.qvel[dofs] = q[i], 0.0
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fullM(model, data, mass)
        mujoco.mj_rne(model, data, 0, bias)
        weight[i], inertia[i] = bias[dofs], 1 / np.diag(np.linalg.inv(mass))[dofs]
        data.qvel[dofs] = dq[i]
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_rne(model, data, 0, bias)
        needed[i] = (mass[np.ix_(dofs, dofs)] @ ddq[i]) + bias[dofs]
    return needed, weight, inertia


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
