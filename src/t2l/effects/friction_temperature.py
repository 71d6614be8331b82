"""Dry friction that follows the logged temperature."""

import math

from t2l.effects.effect import Effect, Parameter
from t2l.effects.warming import REFERENCE_C
from t2l.sim.loop import over_ticks


class FrictionTemperature(Effect):
    """τ = −Fc sign(q̇), with Fc = max(F25 + c (θ − 25 °C), 0)."""

    name = "friction_temperature"
    title = "friction that follows temperature"
    parameters = (
        Parameter(
            "torque", "N·m", -math.inf, 10.0, "friction at 25 °C, added to the MJCF's",
            adds_to="dof_frictionloss", kinked=True, scale="torque",
        ),
        Parameter("per_kelvin", "N·m/K", -1.0, 1.0, "change of it, c", size=1e-3, scale="torque"),
    )  # fmt: skip
    summary = "dry friction that falls or grows with the temperature of the joint"
    signature = "the error follows the direction of motion, by more the colder the joint is"
    source = "Bittencourt and Gunnarsson, Static friction in a robot joint, 2012"
    remembers = False
    contains = ("coulomb_friction",)
    follows = "direction"
    needs = ("temperature",)

    def export(self, to, joints, values):
        to.cannot_carry(self.name, "a simulator has no temperature")

    def install(self, loop, rows, joints, values):
        here = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, dq, motor, level):
            warmer = loop.logged("temperature", tick, self.name)[here] - REFERENCE_C
            level[here] += values["torque"] + values["per_kelvin"] * warmer

        loop.friction.append(add)

    def starts(self, scales):
        return [
            {"torque": f * scales.torque, "per_kelvin": c * f * scales.torque}
            for f in (0.03, 0.3)
            for c in (0.0, -0.02, 0.02)
        ]
