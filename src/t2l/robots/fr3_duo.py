"""Two Franka Research 3 with Franka Hands that face each other, as one robot."""

import math
from collections.abc import Callable
from dataclasses import replace

import mujoco

from t2l.robots.fr3 import FR3Hand
from t2l.robots.specs import let_collide

# by arm, what MuJoCo's `attach` puts before its names: x of the base, m, and its turn about z, rad
BASES = {"left": (-0.6, 0.0), "right": (0.6, math.pi)}

# gripper pointing down, 0.40 m in front of the base and 0.40 m above the table: as far again from
# the other's
HOME = (0.0, -0.5, 0.0, -2.38, 0.0, 1.88, math.pi / 4)


class FR3Duo(FR3Hand):
    """`left` looks along +x and `right` along -x; the world's origin lies halfway between them.

    Hands and wrists of the two arms collide with each other.
    """

    name = "fr3_duo"
    groups = tuple(
        replace(group, name=arm, home=HOME).prefixed(f"{arm}/")
        for arm in BASES
        for group in FR3Hand.groups
    )

    def bare(self) -> mujoco.MjSpec:
        """See `Robot.bare`."""
        return _facing(super().bare)

    def spec(self, gravity_compensation: bool = True, visual: bool = False) -> mujoco.MjSpec:
        """See `Robot.spec`."""
        arm = super().spec
        spec = _facing(lambda: arm(gravity_compensation, visual))
        let_collide(*(spec.body(f"{arm}/base") for arm in BASES))
        return spec


def _facing(arm: Callable[[], mujoco.MjSpec]) -> mujoco.MjSpec:
    """Two copies of an arm, each on its base."""
    both = mujoco.MjSpec()
    for name, (x, turn) in BASES.items():
        one = arm()
        # `attach` wants the options of both to be equal
        both.option = one.option
        quat = (math.cos(turn / 2), 0, 0, math.sin(turn / 2))
        frame = both.worldbody.add_frame(pos=(x, 0, 0), quat=quat)
        both.attach(one, frame=frame, prefix=f"{name}/")
    return both
