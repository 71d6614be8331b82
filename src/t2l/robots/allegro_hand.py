"""Allegro Hand, right: a hand of 16 joints that stands still, palm up.

`allegro_hand.xml` says where its figures are from. It has simple shapes in place of meshes. What is
stated here is IsaacLab's `ALLEGRO_HAND_CFG`: stiffness, damping, torque and velocity limits.
"""

import math
from pathlib import Path

import mujoco

from t2l.robots.robot import JointGroup, Robot
from t2l.robots.specs import add_position_actuator, compensate_gravity

FINGERS = ("ff", "mf", "rf")
JOINTS = tuple(f"{finger}j{i}" for finger in (*FINGERS, "th") for i in range(4))
PALM = "palm"

# rad: fingers and thumb stand about what lies in the palm
FINGER, THUMB = (0.0, 0.0, 0.9, 0.7), (1.2, 0.6, 0.3, 0.3)


class AllegroHand(Robot):
    """Gains of a cell are factors on IsaacLab's stiffness and damping, as those of the humanoid."""

    name = "allegro_hand"
    groups = (
        JointGroup(
            name="hand",
            joints=JOINTS,
            # those of the fingers share an action scale, those of the thumb another
            proximal=len(FINGERS) * len(FINGER),
            home=(*len(FINGERS) * FINGER, *THUMB),
            velocity_limit=(2 * math.pi,) * len(JOINTS),
            torque_limit=(0.5,) * len(JOINTS),
            # none is published
            torque_rate_limit=(math.inf,) * len(JOINTS),
            tool_site=PALM,
            stiffness=(3.0,) * len(JOINTS),
            damping=(0.1,) * len(JOINTS),
        ),
    )
    scale_groups = ("fingers", "thumb")
    palm = PALM

    def mjcf(self) -> Path:
        """The file beside this one."""
        return Path(__file__).with_suffix(".xml")

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`; all of its shapes touch."""
        spec = self.bare()
        compensate_gravity(spec, gravity_compensation)
        for joint in self.joints:
            add_position_actuator(spec, joint, kp=3.0, kv=0.1)
        return spec
