"""Unitree G1, a humanoid of 37 joints with a base that floats: the one of IsaacLab and the study.

`unitree_g1.xml` says where its figures are from. It has simple shapes in place of meshes. What is
stated here is IsaacLab's `G1_MINIMAL_CFG`: pose, stiffness, damping and torque limits. The machine
itself gives less, 88 N·m at a hip and 139 N·m at a knee by Menagerie.
"""

import math
from pathlib import Path

import mujoco

from t2l.robots.robot import JointGroup, Robot, Walker
from t2l.robots.specs import add_position_actuator, compensate_gravity

SIDES = ("left", "right")
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow_pitch", "elbow_roll")
FINGERS = ("zero", "one", "two", "three", "four", "five", "six")
WAIST = "torso_joint"


def _both(*names: str) -> tuple[str, ...]:
    """Joints of these names, of one side after the other."""
    return tuple(f"{side}_{name}_joint" for side in SIDES for name in names)


LOWER = (*_both(*LEG), WAIST)
JOINTS = (*LOWER, *_both(*ARM, *FINGERS))

# rad; joints that are not named are at 0
HOME = {
    **dict.fromkeys(_both("hip_pitch"), -0.20),
    **dict.fromkeys(_both("knee"), 0.42),
    **dict.fromkeys(_both("ankle_pitch"), -0.23),
    **dict.fromkeys(_both("shoulder_pitch"), 0.35),
    **dict.fromkeys(_both("elbow_pitch"), 0.87),
    "left_shoulder_roll_joint": 0.16, "right_shoulder_roll_joint": -0.16,
    "left_one_joint": 1.0, "right_one_joint": -1.0,
    "left_two_joint": 0.52, "right_two_joint": -0.52,
}  # fmt: skip

# N·m/rad, N·m·s/rad, N·m: stiffness, damping and torque limit
DRIVES = {
    **dict.fromkeys(_both("hip_pitch", "knee"), (200.0, 5.0, 300.0)),
    **dict.fromkeys(_both("hip_roll", "hip_yaw"), (150.0, 5.0, 300.0)),
    **dict.fromkeys(_both("ankle_pitch", "ankle_roll"), (20.0, 2.0, 20.0)),
    **dict.fromkeys(_both(*ARM, *FINGERS), (40.0, 10.0, 300.0)),
    WAIST: (200.0, 5.0, 300.0),
}

# rad/s, of Unitree's motors as mjlab 1.6 has them (`g1_constants.py`); of fingers none is published
VELOCITY = {
    **dict.fromkeys((*_both("hip_pitch", "hip_yaw"), WAIST), 32.0),
    **dict.fromkeys(_both("hip_roll", "knee"), 20.0),
    **dict.fromkeys(_both("ankle_pitch", "ankle_roll", *ARM), 37.0),
    **dict.fromkeys(_both(*FINGERS), math.inf),
}


class UnitreeG1(Robot):
    """Gains of a cell are factors on IsaacLab's stiffness and damping, as in the study."""

    name = "unitree_g1"
    groups = (
        JointGroup(
            name="body",
            joints=JOINTS,
            # the study's groups: lower and upper body
            proximal=len(LOWER),
            home=tuple(HOME.get(joint, 0.0) for joint in JOINTS),
            velocity_limit=tuple(VELOCITY[joint] for joint in JOINTS),
            torque_limit=tuple(DRIVES[joint][2] for joint in JOINTS),
            # none is published
            torque_rate_limit=(math.inf,) * len(JOINTS),
            tool_site="head",
            stiffness=tuple(DRIVES[joint][0] for joint in JOINTS),
            damping=tuple(DRIVES[joint][1] for joint in JOINTS),
        ),
    )
    scale_groups = ("lower", "upper")
    walker = Walker(
        base="floating_base_joint",
        height_m=0.74,
        feet=tuple(f"{side}_ankle_roll_link" for side in SIDES),
        trunk="torso_link",
        legs=_both("hip_pitch", "hip_roll", "hip_yaw", "knee"),
        ankles=_both("ankle_pitch", "ankle_roll"),
        sideways=_both("hip_roll", "hip_yaw"),
        arms=_both(*ARM),
        fingers=_both(*FINGERS),
        waist=(WAIST,),
    )

    def mjcf(self) -> Path:
        """The file beside this one."""
        return Path(__file__).with_suffix(".xml")

    def spec(self, gravity_compensation: bool = False, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        spec = self.bare()
        for geom in list(spec.geoms):
            if not (visual or geom.contype):
                spec.delete(geom)
        compensate_gravity(spec, gravity_compensation)
        for joint in self.joints:
            add_position_actuator(spec, joint, kp=100.0, kv=10.0)
        return spec
