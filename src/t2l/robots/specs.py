"""What robots, and what else moves in a scene, do to a MjSpec."""

import mujoco

# bit 1: the scene; robot geoms touch what has it and never one another
COLLIDES_WITH_SCENE = {"contype": 2, "conaffinity": 1, "group": 3}


def hold_at_rest(joint: mujoco.MjsJoint) -> None:
    """Let a joint's Coulomb friction hold it at rest; MuJoCo's default of 0.9 lets it creep."""
    joint.solimp_friction[:2] = 0.9999


def compensate_gravity(spec: mujoco.MjSpec, compensated: bool) -> None:
    """Let every body of a robot be free of its own weight, or feel it."""
    for body in spec.bodies:
        if body.name:
            body.gravcomp = float(compensated)
