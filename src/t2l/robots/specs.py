"""What robots, and what else moves in a scene, do to a MjSpec."""

import mujoco

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
