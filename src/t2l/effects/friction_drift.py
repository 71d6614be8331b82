"""Dry friction that changes while the machine warms up."""

import math

import numpy as np

from t2l.effects import warming
from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class FrictionDrift(Effect):
    """τ = −Fc(t) sign(q̇), with Fc(t) = F1 + (F0 − F1) e^(−t/T)."""

    name = "friction_drift"
    title = "friction that drifts with time"
    parameters = (
        *(
            Parameter(
                f"at_{when}", "N·m", -math.inf, 10.0,
                f"friction at the {when}, added to the MJCF's",
                adds_to="dof_frictionloss", kinked=True, scale="torque",
            )
            for when in ("start", "end")
        ),
        warming.TIME_CONSTANT,
    )  # fmt: skip
    summary = "dry friction that changes as the machine runs, as of grease that warms up"
    signature = "the error follows the direction of motion, and by how much changes with time"
    source = "Bittencourt and Gunnarsson, Static friction in a robot joint, 2012"
    remembers = False
    contains = ("coulomb_friction",)
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, np.zeros(len(joints)))
        to.call(self.name, friction_that_drifts, joints, values)

    def install(self, loop, rows, joints, values):
        here = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, dq, motor, level):
            level[here] += warming.at(loop, rows, tick, values)

        loop.friction.append(add)

    def starts(self, scales):
        return [
            {
                "at_start": first * scales.torque,
                "at_end": last * scales.torque,
                "time_constant": np.array([time_s]),
            }
            for time_s in warming.TIMES_S
            for first, last in ((0.1, 0.03), (0.03, 0.1))
        ]


def friction_that_drifts(robot, joints, values):
    """Add Fc(t)."""
    left = np.exp(-(robot.data.time + 0.5 * robot.period_s) / values["time_constant"])
    change = (values["at_start"] - values["at_end"]) * left
    robot.friction[joints] += values["at_end"] + change
