"""A robot of one's own: an arm of three joints, in an MJCF beside this file."""

from pathlib import Path

import mujoco

from t2l.robots import JointGroup, Robot
from t2l.robots.plant import position_controlled


class ThreeJointArm(Robot):
    """Turns about the vertical, lifts, and bends its elbow."""

    name = "three_joint_arm"
    groups = (
        JointGroup(
            name="arm",
            joints=("turn", "lift", "bend"),
            proximal=1,
            home=(0.0, -0.5, 1.0),
            velocity_limit=(3.0, 3.0, 3.0),
            torque_limit=(40.0, 40.0, 20.0),
            torque_rate_limit=(2000.0, 2000.0, 2000.0),
            tool_site="tip",
        ),
    )

    def mjcf(self) -> Path:
        return Path(__file__).with_suffix(".xml")

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        return position_controlled(self)
