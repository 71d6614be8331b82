"""What ties joints of a robot to something else, which its plant has not."""

from collections.abc import Sequence

import mujoco

from t2l.robots import plant

CLOSING = (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD)


def couplings(robot: str, joints: Sequence[str]) -> list[str]:
    """Sentences about what `plant.load` leaves out although it ties the motion of `joints`.

    It is a `mimic` of a URDF, or a constraint in <equality> of an MJCF.
    """
    spec, driven = plant.read(robot), set(joints)
    return [
        f"{said}, which is left out"
        for equality in spec.equalities
        for said in _of_joints(equality, driven) + _of_bodies(spec, equality, driven)
    ]


def _of_joints(equality: mujoco.MjsEquality, driven: set[str]) -> list[str]:
    tied = {equality.name1, equality.name2} - {""}
    if equality.type != mujoco.mjtEq.mjEQ_JOINT or not driven & tied:
        return []
    still = ", ".join(sorted(tied - driven))
    instead = f"{still} is held still" if still else "each moves alone"
    follows = f"joint {equality.name1} follows {equality.name2 or 'nothing'}"
    return [f"{instead}: by the robot's file {follows}"]


def _of_bodies(spec: mujoco.MjSpec, equality: mujoco.MjsEquality, driven: set[str]) -> list[str]:
    if equality.type not in CLOSING:
        return []
    names = equality.name1, equality.name2
    sides = [_joints_above(spec, equality.objtype, name) for name in names]
    moved = ", ".join(sorted(driven & (sides[0] ^ sides[1])))
    joined = f"{names[0]} and {names[1] or 'the world'} are joined"
    return [f"{moved} moves freely: by the robot's file {joined}"] if moved else []


def _joints_above(spec: mujoco.MjSpec, kind: mujoco.mjtObj, name: str) -> set[str]:
    if not name:
        return set()
    body = spec.site(name).parent if kind == mujoco.mjtObj.mjOBJ_SITE else spec.body(name)
    found = set()
    while body is not None and body.name != "world":
        found |= {joint.name for joint in body.joints}
        body = body.parent
    return found
