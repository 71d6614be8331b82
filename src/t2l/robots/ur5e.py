"""Universal Robots UR5e: the arm of MuJoCo Menagerie, bare or with a Robotiq 2F-85.

The base stands as in Menagerie's MJCF, whose frame is the one of the robot's controller: with all
joints at zero the arm lies along -x.
"""

import math
from dataclasses import replace
from pathlib import Path

import mujoco

from t2l.robots import menagerie, robotiq_2f85
from t2l.robots.robot import JointGroup, Robot
from t2l.robots.specs import COLLIDES_WITH_SCENE, add_position_actuator, compensate_gravity

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
FLANGE = "attachment_site"

ARM = JointGroup(
    name="arm",
    joints=JOINTS,
    # shoulder and elbow
    proximal=3,
    # flange pointing down, 0.50 m in front of the base (+x) and 0.40 m above it, elbow up
    home=(2.87, -1.57, 1.80, -1.80, -math.pi / 2, -0.27),
    # Universal Robots e-Series, User Manual UR5e, technical specifications: 180°/s at all joints
    velocity_limit=(math.pi,) * 6,
    # Universal Robots, article "Max. joint torques": joints of size 3, then of size 1
    torque_limit=(150.0, 150.0, 150.0, 28.0, 28.0, 28.0),
    # none is published
    torque_rate_limit=(math.inf,) * 6,
    tool_site=FLANGE,
)


class UR5e(Robot):
    """The arm without a tool.

    Ranges are the MJCF's: ±360° as in the manual, and ±180° for the elbow, which the arm's own
    links do not let turn further.
    """

    name = "ur5e"
    groups = (ARM,)

    def mjcf(self) -> Path:
        """Menagerie's file."""
        return menagerie.model("universal_robots_ur5e", "ur5e.xml")

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        spec = _arm(self.mjcf(), visual)
        compensate_gravity(spec, gravity_compensation)
        return spec


class UR5e2F85(UR5e):
    """The arm with a Robotiq 2F-85."""

    name = "ur5e_2f85"
    groups = (
        replace(
            ARM,
            # the grip there, where the flange is without it
            home=(2.87, -1.578, 1.387, -1.380, -math.pi / 2, -0.27),
            tool_site=robotiq_2f85.GRIP_SITE,
            gripper=robotiq_2f85.GRIPPER,
        ),
    )

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        spec = _arm(self.mjcf(), visual)
        robotiq_2f85.attach(spec, spec.site(FLANGE), visual)
        compensate_gravity(spec, gravity_compensation)
        return spec


def _arm(path: Path, visual: bool) -> mujoco.MjSpec:
    """The arm with inertias, armature and joint limits of `path`, which states no friction.

    Its capsules of forearm and wrist, the links that can reach a table, collide with the scene.
    """
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in list(spec.geoms):
        looks = geom.type == mujoco.mjtGeom.mjGEOM_MESH
        if looks and not visual:
            spec.delete(geom)
        elif not looks:
            if geom.parent.name.startswith(("forearm", "wrist")):
                for key, value in COLLIDES_WITH_SCENE.items():
                    setattr(geom, key, value)
            else:
                spec.delete(geom)
    for element in [
        *([] if visual else spec.meshes), *spec.lights, *spec.actuators, *spec.keys,
    ]:  # fmt: skip
        spec.delete(element)
    for joint in JOINTS:
        add_position_actuator(spec, joint, kp=100.0, kv=10.0)
    return spec
