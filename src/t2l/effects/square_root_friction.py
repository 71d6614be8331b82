"""Friction that grows with the root of the velocity."""

import numpy as np

from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class SquareRootFriction(Effect):
    """τ = −c sign(q̇) √|q̇|."""

    name = "square_root_friction"
    title = "square-root friction"
    parameters = (
        Parameter(
            "coefficient", "N·m·√(s/rad)", 0.0, 10.0, "c", kinked=True,
            scale="torque / sqrt(velocity)",
        ),
    )  # fmt: skip
    summary = "friction of grease and gears that grows ever more slowly with the velocity"
    signature = "the error grows steeply at low velocity and flattens at high velocity"
    source = (
        "Wolf and Iskandar, Extending a dynamic friction model with nonlinear viscous and thermal "
        "dependency for a motor and harmonic drive gear, 2018: |q̇|^δ, here with δ = 1/2"
    )
    remembers = False
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, np.zeros(len(joints)))
        to.call(self.name, grow_by_root, joints, values)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        # as dry friction, which never turns a joint back
        @over_ticks
        def add(tick, dq, motor, level):
            level[at] += values["coefficient"] * np.sqrt(np.abs(dq[at]))

        loop.friction.append(add)

    def starts(self, scales):
        root = np.sqrt(scales.velocity)
        return [{"coefficient": f * scales.torque / root} for f in (0.02, 0.1, 0.4)]


def grow_by_root(robot, joints, values):
    """Add friction of the root of the velocity."""
    root = np.sqrt(np.abs(robot.rate[joints]))
    robot.friction[joints] += values["coefficient"] * root
