"""A motor and a link on one axis, with something between them that gives."""

import mujoco
import numpy as np

from t2l.sim.servo import ServoLoop

LEAST_MOTOR_INERTIA = 0.05  # of the link's mass on the axis at 10 cm, where the MJCF has none


def add_joint(spec: mujoco.MjSpec, name: str, suffix: str) -> mujoco.MjsJoint:
    """Give the body of joint `name` a second joint on the same axis, from motor to link.

    The first joint, with its armature and friction, becomes the motor.
    """
    motor = spec.joint(name)
    if motor.armature <= 0:
        motor.armature = LEAST_MOTOR_INERTIA * 0.01 * max(motor.parent.mass, 0.1)
    between = motor.parent.add_joint(
        name=f"{name}/{suffix}", type=motor.type, axis=motor.axis, pos=motor.pos
    )
    between.damping[:] = 0.0
    between.armature = 0.0
    between.frictionloss = 0.0
    between.stiffness[:] = 0.0
    between.limited = 0
    return between


def addresses(loop: ServoLoop, joints: np.ndarray, suffix: str) -> tuple[np.ndarray, np.ndarray]:
    """qpos and dof addresses (k,) of the joints between motor and link."""
    added = [loop.batch.model.joint(f"{loop.joints[j]}/{suffix}") for j in joints]
    return (
        np.array([joint.qposadr[0] for joint in added]),
        np.array([joint.dofadr[0] for joint in added]),
    )


def gravity_compensation_on_motor_only(loop: ServoLoop, rows: slice, dofs: np.ndarray) -> None:
    """Take off the joints between the compensation that only the motor can give."""
    compensation, applied = loop.batch.bind("qfrc_gravcomp"), loop.batch.qfrc_applied

    def add(tick, q, dq, torque):
        applied[rows, dofs] = -compensation[rows, dofs]

    loop.joint_torques.append(add)


def encoder_at(
    loop: ServoLoop, rows: slice, joints: np.ndarray, qpos: np.ndarray, dofs: np.ndarray, link
) -> None:
    """Read the link's angle instead of the motor's where `link` (nrow, 1) is 1."""
    if not np.any(link):
        return

    position, velocity, at = loop.batch.qpos, loop.batch.qvel, (rows, loop.columns(joints))

    def change(tick, q, dq):
        q[at] += link * position[rows, qpos]
        dq[at] += link * velocity[rows, dofs]

    loop.sensor_filters.append(change)
