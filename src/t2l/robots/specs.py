"""What robots, and what else moves in a scene, do to a MjSpec."""

import mujoco
import numpy as np

WRIST_CAMERA = "wrist"

# bit 1: the scene; geoms of an arm touch what has it and never one another
COLLIDES_WITH_SCENE = {"contype": 2, "conaffinity": 1, "group": 3}
# bit 3: between two arms of a robot
_OTHER_ARM = 4


def hold_at_rest(joint: mujoco.MjsJoint) -> None:
    """Let a joint's Coulomb friction hold it at rest; MuJoCo's default of 0.9 lets it creep."""
    joint.solimp_friction[:2] = 0.9999


def let_collide(one: mujoco.MjsBody, other: mujoco.MjsBody) -> None:
    """Let two arms, given by their bases, touch each other with what touches the scene."""
    for geom in _colliders(one):
        geom.contype |= _OTHER_ARM
    for geom in _colliders(other):
        geom.conaffinity |= _OTHER_ARM


def _colliders(arm: mujoco.MjsBody) -> list[mujoco.MjsGeom]:
    return [geom for geom in arm.find_all("geom") if geom.contype]


def compensate_gravity(spec: mujoco.MjSpec, compensated: bool) -> None:
    """Let every body of a robot be free of its own weight, or feel it."""
    for body in spec.bodies:
        if body.name:
            body.gravcomp = float(compensated)


def add_position_actuator(
    spec: mujoco.MjSpec, joint: str, kp: float, kv: float
) -> mujoco.MjsActuator:
    """Give a joint a position actuator of its name, N·m/rad and N·m·s/rad, or N/m and N·s/m."""
    actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=kp, kv=kv)
    return actuator


def add_wrist_camera(hand: mujoco.MjsBody, grip_z: float) -> None:
    """Mount a camera on a hand whose z is the approach direction, as a user of the hand would.

    It stands 8 cm off the hand's axis, clear of the housing, and looks 5 cm beyond the grip, so
    that the fingertips and what is below them are seen.

    Args:
        grip_z: from the hand's origin to the grip, m.
    """
    position = np.array([0.08, 0, 0.02])
    # a camera looks along its -z
    back = position - [0, 0, grip_z + 0.05]
    right = np.array([0, 1, 0])
    up = np.cross(back, right)
    # a wide lens: the table is seen from 0.4 m above it, and the grip from near
    hand.add_camera(name=WRIST_CAMERA, pos=position, xyaxes=[*right, *up], fovy=75)
