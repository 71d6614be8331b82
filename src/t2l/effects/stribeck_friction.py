"""Dry friction that is larger at rest than in motion."""

import math

import numpy as np

from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class StribeckFriction(Effect):
    """τ = −(Fc + Fs exp(−(q̇/vs)²)) sign(q̇): the steady state of LuGre friction."""

    name = "stribeck_friction"
    title = "Stribeck friction"
    parameters = (
        Parameter(
            "coulomb", "N·m", -math.inf, 10.0, "friction in fast motion, added to the MJCF's",
            adds_to="dof_frictionloss", kinked=True, scale="torque",
        ),
        Parameter(
            "extra_at_rest", "N·m", 0.0, 10.0, "by how much breakaway exceeds it", kinked=True,
            scale="torque",
        ),
        Parameter(
            "velocity", "rad/s", 0.003, 10.0, "velocity at which the excess fades", log=True,
            scale="velocity",
        ),
    )  # fmt: skip
    summary = "dry friction that falls from a breakaway torque to a lower level in motion"
    signature = "the error follows the direction of motion and is largest in slow motion"
    source = "Canudas de Wit et al., A new model for control of systems with friction, 1995, eq. 4"
    remembers = False
    contains = ("coulomb_friction",)
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, values["coulomb"])
        to.call(self.name, fade_with_velocity, joints, values)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, dq, motor, level):
            speed = dq[at] / values["velocity"]
            level[at] += values["coulomb"] + values["extra_at_rest"] * np.exp(-(speed**2))

        loop.friction.append(add)

    def starts(self, scales):
        return [
            {
                "coulomb": level * scales.torque,
                "extra_at_rest": extra * scales.torque,
                "velocity": fade * scales.velocity,
            }
            for level, extra, fade in (
                (0.01, 0.01, 0.1), (0.01, 0.01, 0.4), (0.1, 0.1, 0.1), (0.1, 0.1, 0.4),
                (0.5, 0.5, 0.1),
            )
        ]  # fmt: skip


def fade_with_velocity(robot, joints, values):
    """Add what breakaway has beyond friction in motion."""
    speed = robot.rate[joints] / values["velocity"]
    robot.friction[joints] += values["extra_at_rest"] * np.exp(-(speed**2))
