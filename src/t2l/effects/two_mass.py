"""A motor and a link on one axis, with something between them that gives."""

from collections.abc import Callable

import mujoco
import numpy as np

from t2l.effects.exported import Exported
from t2l.sim.loop import over_ticks
from t2l.sim.servo import ServoLoop

# tuned: of what it moves: of a motor, where the MJCF has none, of its link's mass at 10 cm; of what
# lies between two joints that give, of the motor's
LEAST_INERTIA = 0.1
SETTLINGS = 6  # numerics: times that a load is looked at where the last one bent what lies between


def add_joint(spec: mujoco.MjSpec, name: str, suffix: str) -> mujoco.MjsJoint:
    """Give the body of joint `name` a second joint on the same axis, from motor to link.

    The first joint, with its armature and friction, becomes the motor.
    """
    motor = spec.joint(name)
    gives_already = any(joint.name.startswith(f"{name}/") for joint in motor.parent.joints)
    if motor.armature <= 0:
        # format: (10 cm)²
        motor.armature = LEAST_INERTIA * 0.01 * _moved(spec, name)
    between = motor.parent.add_joint(
        name=f"{name}/{suffix}", type=motor.type, axis=motor.axis, pos=motor.pos
    )
    between.damping[:] = 0.0
    between.armature = LEAST_INERTIA * motor.armature if gives_already else 0.0
    between.frictionloss = 0.0
    between.stiffness[:] = 0.0
    between.limited = 0
    return between


def _moved(spec: mujoco.MjSpec, joint: str) -> float:
    """Mass of a joint's link, kg; of what hangs on it where it has none."""
    model = spec.copy().compile()
    body = model.joint(joint).bodyid[0]
    return float(model.body_mass[body] or model.body_subtreemass[body])


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
    held = loop.until_next()

    @over_ticks  # what is applied there no joint that is led is told
    def add(tick, q, dq, torque):
        applied[rows, dofs] = -held(tick, compensation[rows, dofs])

    loop.joint_torques.append(add)


def give(loop: ServoLoop, rows: slice, joints: np.ndarray, stiffness, damping, play, link) -> None:
    """Tell the loop what lies between, (nrow, k); `link` (nrow, 1) is 1 where an encoder shows it.

    Of two that give in series the softer bears what the other does.
    """
    at, own = (rows, loop.columns(joints)), loop.transmission
    own.stiffness[at] = 1 / (1 / own.stiffness[at] + 1 / stiffness)
    own.damping[at] = np.maximum(own.damping[at], damping)
    own.play[at] += play
    own.on_link[at] = np.maximum(own.on_link[at], link)


def encoder_at(
    loop: ServoLoop, rows: slice, joints: np.ndarray, qpos: np.ndarray, dofs: np.ndarray, link
) -> None:
    """Read the link's angle instead of the motor's where `link` (nrow, 1) is 1."""
    if not np.any(link):
        return

    position, velocity, at = loop.batch.qpos, loop.batch.qvel, (..., rows, loop.columns(joints))

    @over_ticks  # of a plant that is led, nothing gives
    def change(tick, q, dq):
        q[at] += link * position[rows, qpos]
        dq[at] += link * velocity[rows, dofs]

    loop.sensor_filters.append(change)


def export_encoder(to: Exported, effect: str, joints: np.ndarray, suffix: str, link: float) -> None:
    """Let the exported robot read the link's angle where `link` is 1."""
    if link > 0:
        to.read_too.extend((effect, int(j), f"{to.joints[j]}/{suffix}", link) for j in joints)


def start_under_load(
    loop: ServoLoop,
    rows: slice,
    joints: np.ndarray,
    between: tuple[np.ndarray, np.ndarray],
    link,
    angle: Callable[[np.ndarray], np.ndarray],
    farthest: np.ndarray | float = np.inf,
) -> None:
    """Start with the joints between at rest under their load, the encoder where it was measured.

    Or as `ServoLoop.hidden_start` says, where a recording begins in motion.

    Args:
        between: qpos and dof addresses (k,), as of `addresses`.
        link: (nrow, 1), 1 where the encoder measures the link.
        angle: of the joints between (nrow, k), rad, from their loads (nrow, k), N·m.
        farthest: (nrow, k) rad to either side; beyond, only the load bends them.
    """
    qpos, dofs = between
    bias = loop.batch.bind("qfrc_bias")  # before the start is computed, which fills it

    def settle(loop):
        turned, motor = loop.batch.qpos, loop.qpos[joints]
        own = turned[rows, motor].copy()
        beyond, velocity = np.moveaxis(loop.hidden_start[rows, joints, :2], -1, 0)
        for _ in range(SETTLINGS):
            rest = angle(bias[rows, dofs])
            most = np.maximum(np.abs(rest), farthest)
            start = np.clip(rest + beyond, -most, most)
            turned[rows, qpos], turned[rows, motor] = start, own - link * start
            loop.batch.forward()
        loop.batch.qvel[rows, dofs] = velocity
        loop.batch.qvel[rows, loop.dofs[joints]] -= link * velocity

    loop.settle.append(settle)
