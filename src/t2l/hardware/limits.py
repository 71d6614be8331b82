"""What a robot must not be asked for: positions, velocities and torques, checked beforehand."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from t2l.errors import RecordingError
from t2l.robots import Robot

# a command this close to the end of a range leaves no room to overshoot
POSITION_MARGIN_RAD = 0.05


@dataclass(frozen=True)
class Limits:
    """Limits of a robot's joints, and the model that torques are predicted with.

    Attributes:
        joints: names, in the order of the arrays.
        position: rad, (njoint, 2), lower and upper end of the ranges.
        velocity: rad/s, (njoint,).
        torque: N·m, (njoint,), on top of gravity compensation.
        model: with these joints; gravity is compensated in it if it is on the robot.
    """

    joints: tuple[str, ...]
    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    model: mujoco.MjModel


def limits_of(robot: Robot) -> Limits:
    """Limits of a robot, and its model with the tools on it."""
    return Limits(
        joints=robot.joints,
        position=robot.position_limit,
        velocity=robot.velocity_limit,
        torque=robot.torque_limit,
        model=robot.spec(gravity_compensation=True).compile(),
    )


def motion_torque(q_des: np.ndarray, rate_hz: float, limits: Limits) -> np.ndarray:
    """What moving along commands takes, by the model's inverse dynamics with its friction.

    Args:
        q_des: rad, (n, njoint), at `rate_hz`.

    Returns:
        N·m, (n, njoint), without signs.
    """
    dq = np.gradient(q_des, 1 / rate_hz, axis=0)
    ddq = np.gradient(dq, 1 / rate_hz, axis=0)
    model, data = limits.model, mujoco.MjData(limits.model)
    joints = [model.joint(name) for name in limits.joints]
    qpos, dofs = (np.array([getattr(j, a)[0] for j in joints]) for a in ("qposadr", "dofadr"))
    motion = np.empty_like(q_des)
    for row in range(len(q_des)):
        data.qpos[qpos], data.qvel[dofs], data.qacc[dofs] = q_des[row], dq[row], ddq[row]
        mujoco.mj_inverse(model, data)
        motion[row] = data.qfrc_inverse[dofs]
    return np.abs(motion)


def predicted_torque(q_des: np.ndarray, kp: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """What following commands closely takes.

    The sum of what the motion itself takes and of what a held command adds the moment it is
    replaced: Kp times the step to the next. An arm that lags behind and swings may need more.

    Args:
        q_des: rad, (n, njoint).
        kp: N·m/rad, (njoint,).
        motion: N·m, (n, njoint), from `motion_torque`.

    Returns:
        N·m, (n, njoint), without signs.
    """
    step = np.abs(np.diff(q_des, axis=0, prepend=q_des[:1]))
    return motion + kp * step


def check_commands(
    q_des: np.ndarray,
    rate_hz: float,
    kp: np.ndarray,
    motion: np.ndarray,
    limits: Limits,
    path: Path,
    what: str,
) -> None:
    """Whether a robot can be given these commands, before anything moves.

    Args:
        q_des: rad, (n, njoint), one row every 1/`rate_hz` s.
        kp: N·m/rad, (njoint,), the stiffness that turns steps into torque.
        motion: N·m, (n, njoint), from `motion_torque`.
        path: of the configuration, for messages.
        what: which of its motions this is, for messages.

    Raises:
        RecordingError: a position, velocity or torque beyond its limit, with joint, time, value
            and limit.
    """

    def refuse(
        outside: np.ndarray, values: np.ndarray, unit: str, allowed: Callable[[int], str]
    ) -> None:
        if outside.any():
            row, joint = np.argwhere(outside)[0]
            where = f"{what}: {limits.joints[joint]} at {row / rate_hz:.2f} s"
            raise RecordingError(path, where, f"{values[row, joint]:.4g} {unit}", allowed(joint))

    low, high = (limits.position + np.array([1, -1]) * POSITION_MARGIN_RAD).T
    refuse(
        (q_des < low) | (q_des > high),
        q_des,
        "rad",
        lambda j: f"{low[j]:.4g} to {high[j]:.4g} rad, {POSITION_MARGIN_RAD} rad within its range",
    )
    velocity = np.diff(q_des, axis=0, prepend=q_des[:1]) * rate_hz
    refuse(
        np.abs(velocity) > limits.velocity,
        velocity,
        "rad/s",
        lambda j: f"up to {limits.velocity[j]:g} rad/s",
    )
    torque = predicted_torque(q_des, kp, motion)
    refuse(
        torque > limits.torque,
        torque,
        "N·m, as the model predicts",
        lambda j: f"up to {limits.torque[j]:g} N·m",
    )


def check_state(q: np.ndarray, dq: np.ndarray, limits: Limits, path: Path, where: str) -> None:
    """Whether a moving robot is still within its limits.

    Args:
        q: rad, (njoint,), measured.
        dq: rad/s, (njoint,), measured.

    Raises:
        RecordingError: it is not, so that the motion must end.
    """
    low, high = limits.position.T
    for outside, values, unit in (
        ((q < low) | (q > high), q, "rad"),
        (np.abs(dq) > limits.velocity, dq, "rad/s"),
    ):
        if outside.any():
            joint = int(np.argmax(outside))
            allowed = (
                f"{low[joint]:.4g} to {high[joint]:.4g} rad"
                if unit == "rad"
                else f"up to {limits.velocity[joint]:g} rad/s"
            )
            raise RecordingError(
                path,
                f"{where}, {limits.joints[joint]} measured",
                f"{values[joint]:.4g} {unit}, so the arm was stopped",
                allowed,
            )
