"""Numbers of recordings that cannot be in the units they are read in, asked about before a fit.

Each is a question with the numbers that raise it: what one machine cannot have another may.
"""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from t2l.identify.loop_stability import plants, poses
from t2l.identify.model import Model
from t2l.recordings.recording import Recording
from t2l.robots import plant
from t2l.sim.sampled_loop import chatter, transition

REGISTER = "register"
ROWS = 2000  # numerics: of all recordings together
LEAST_ROWS = 10  # numerics: of each
# bound: of a joint without limits: two turns either way
MOST_RAD = 4 * np.pi
# bound: of real machines, and of light joints that the model lacks friction of, at most 215
MOST_OVER_NEEDED = 500.0
# bound: of real machines at most 21, of a servo that saturates in steps
MOST_OVER_LIMIT = 100.0
# bound: of real machines that hold their own weight at least 0.18
LEAST_OVER_WEIGHT = 0.05
# bound: Kp h²/M; controllers are designed for 0.04 to 0.4 (Åström and Wittenmark, Computer-
# controlled systems, 1997, section 2.8), real machines here have up to 0.007
FASTEST = 1.0
# bound: a rad/s is 57 deg/s; filters of velocity lose less than the rest
SPEED_FACTOR = 10.0
MOVES_RAD_S = 0.05  # numerics: RMS, below which velocity is noise


def questions(model: Model, recordings: Sequence[Recording]) -> list[str]:
    """What to ask whoever made the recordings, at most one sentence a joint and kind."""
    bare = plant.compiled(plant.load(model.robot, recordings[0].joints), model.robot)
    rows = max(LEAST_ROWS, ROWS // len(recordings))
    asked = {(joint, REGISTER): said for joint, said in _too_fast(model, recordings).items()}
    for recording in recordings:
        for joint, kind, question in _of(bare, recording, rows):
            asked.setdefault((joint, kind), f"{recording.name}: {question}")
    return list(asked.values())


def _too_fast(model: Model, recordings: Sequence[Recording]) -> dict[str, str]:
    """By joint, of loops that settle: those that chatter are told of elsewhere."""
    loops, joints = poses(recordings), recordings[0].joints
    found = plants(model, joints, loops)
    if found is None:
        return {}
    mass, damping, stiffness, kp, kd = found
    period = 1 / loops.rate_hz
    fastest = np.sqrt(kp * np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2))
    beyond = (fastest * period[:, None]) ** 2 > FASTEST
    if not beyond.any():
        return {}
    if (chatter(transition(mass, damping, stiffness, kp, kd, period)) > 1).any():
        return {}
    said = {}
    for j in np.flatnonzero(beyond.any(axis=0)):
        i = int(np.argmax(fastest[:, j] * period))
        said[joints[j]] = (
            f"{loops.names[i]}: {_gain(kp[i, j], joints[j])} gives a natural frequency of "
            f"{fastest[i, j] / 2 / np.pi:.0f} Hz, in a loop of {loops.rate_hz[i]:g} Hz "
            "(control_rate_hz): is it a register of the servo, is control_rate_hz the rate of the "
            "log, or does the model lack armature?"
        )
    return said


def _gain(kp: float, joint: str) -> str:
    return f"Kp {kp:g} N·m/rad on joint {joint}" if kp > 0 else f"the command of joint {joint}"


def _of(model: mujoco.MjModel, recording: Recording, rows: int) -> Iterator[tuple[str, str, str]]:
    """Joint, kind and words of each question about a recording."""
    known = np.flatnonzero(~np.isnan(recording.q).any(axis=1))
    if len(known) < LEAST_ROWS:
        return
    time, q, q_des = recording.time[known], recording.q[known], recording.q_des[known]
    dq = np.gradient(q, time, axis=0)
    few = np.unique(np.linspace(0, len(known) - 1, rows).astype(int))
    ddq = np.gradient(dq, time, axis=0)[few]
    needed, weight = _torques(model, recording.joints, q[few], dq[few], ddq)
    given = recording.kp * (q_des - q)[few] + recording.feed_forward[known][few]
    given = np.clip(given, -recording.stall, recording.stall)
    given *= recording.powered[known][few]
    for j, name in enumerate(recording.joints):
        joint = model.joint(name)
        for kind, question in (
            *_turns(model, joint.id, q[:, j]),
            *_torque(
                model, joint.id, _gain(recording.kp[j], name), _rms(given[:, j]), _rms(needed[:, j])
            ),
        ):
            yield name, kind, question
        follows = 0 < _rms((q_des - q)[:, j]) < np.ptp(q[:, j])
        least = LEAST_OVER_WEIGHT * _rms(weight[:, j])
        stiff = recording.kp[j] > 0
        if stiff and follows and not recording.gravity_compensation and _rms(given[:, j]) < least:
            yield name, "weight", (
                f"{_gain(recording.kp[j], name)} gives {_rms(given[:, j]):.2g} N·m RMS, where its "
                f"weight takes {_rms(weight[:, j]):.2g}: is Kp in N·m/deg, or is "
                "gravity_compensation true?"
            )  # fmt: skip
        if recording.dq is not None:
            for kind, question in _speed(name, recording.dq[known, j], dq[:, j]):
                yield name, kind, question


def _turns(model: mujoco.MjModel, joint: int, q: np.ndarray) -> Iterator[tuple[str, str]]:
    """Of a hinge without limits: the range of others is looked at elsewhere."""
    endless = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and not model.jnt_limited[joint]
    furthest = np.abs(q).max()
    if endless and MOST_RAD < furthest < np.rad2deg(2 * np.pi):
        yield "degrees", (
            f"q.{model.joint(joint).name} goes to {furthest:.3g}, {furthest / 2 / np.pi:.1f} turns "
            "if these are rad: are they degrees?"
        )  # fmt: skip


def _torque(
    model: mujoco.MjModel, joint: int, gain: str, given: float, needed: float
) -> Iterator[tuple[str, str]]:
    """Of RMS torques, N·m: what the gain gives, and what the motion takes without friction."""
    needed += model.dof_frictionloss[model.jnt_dofadr[joint]]
    low, high = model.jnt_actfrcrange[joint]
    limit = max(-low, high) if model.jnt_actfrclimited[joint] else np.inf
    for most, than in (
        (MOST_OVER_NEEDED * needed, f"its motion takes {needed:.2g}"),
        (MOST_OVER_LIMIT * limit, f"the robot's file allows {limit:.2g}"),
    ):
        if given > most:
            asked = f"{gain} asks for {given:.2g} N·m RMS, where {than}"
            yield REGISTER, f"{asked}: is it a register of the servo, or in another unit?"


def _speed(joint: str, measured: np.ndarray, of_q: np.ndarray) -> Iterator[tuple[str, str]]:
    both = ~np.isnan(measured)
    measured, of_q = measured[both], of_q[both]
    if both.sum() < LEAST_ROWS or min(_rms(measured), _rms(of_q)) < MOVES_RAD_S:
        return
    # noise of positions is none of the velocities': it leaves this ratio as it is
    common = float(np.mean(measured * of_q))
    factor = float(np.mean(measured**2)) / common if common > 0 else np.inf
    if SPEED_FACTOR < factor < np.inf:
        yield "velocity", (
            f"dq.{joint} is {factor:.3g} times as fast as q.{joint} changes: is it in deg/s?"
        )  # fmt: skip


def _torques(
    model: mujoco.MjModel, joints: Sequence[str], q: np.ndarray, dq: np.ndarray, ddq: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What motions take and what weights take, (nrow, njoint) N·m each."""
    data = mujoco.MjData(model)
    at = [model.joint(name).qposadr[0] for name in joints]
    dofs = [model.joint(name).dofadr[0] for name in joints]
    needed, weight = np.empty((2, *q.shape))
    bias, mass = np.empty(model.nv), np.zeros((model.nv, model.nv))
    for i in range(len(q)):
        data.qpos[at], data.qvel[dofs] = q[i], 0.0
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fullM(model, data, mass)
        mujoco.mj_rne(model, data, 0, bias)
        weight[i] = bias[dofs]
        data.qvel[dofs] = dq[i]
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_rne(model, data, 0, bias)
        needed[i] = (mass[np.ix_(dofs, dofs)] @ ddq[i]) + bias[dofs]
    return needed, weight


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
