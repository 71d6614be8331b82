"""Dry friction that is not alike in both directions."""

import math

from t2l.effects.coulomb_friction import export_friction
from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class DirectionalFriction(Effect):
    """τ = −F₊ where q̇ > 0, +F₋ where q̇ < 0, and between them whatever holds a joint at rest.

    It is a symmetric friction of (F₊ + F₋)/2 beside a constant torque of (F₋ − F₊)/2.
    """

    name = "directional_friction"
    title = "Coulomb friction with a direction"
    parameters = tuple(
        Parameter(
            way, "N·m", -math.inf, 10.0,
            f"against {sign} velocity, added to the MJCF's frictionloss",
            adds_to="dof_frictionloss", kinked=True, scale="torque",
        )
        for way, sign in (("forward", "positive"), ("backward", "negative"))
    )  # fmt: skip
    summary = "dry friction that is stronger in one direction than in the other"
    signature = "the error follows the direction of motion, by more in one than in the other"
    source = "Armstrong-Hélouvry et al., A survey of models for machines with friction, 1994"
    remembers = False
    contains = ("coulomb_friction",)
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, 0.5 * (values["forward"] + values["backward"]))
        to.constant[joints] += 0.5 * (values["backward"] - values["forward"])

    def install(self, loop, rows, joints, values):
        both = 0.5 * (values["forward"] + values["backward"])
        offset = 0.5 * (values["backward"] - values["forward"])
        loop.added_friction[rows, joints] += both
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def add(tick, q, dq, torque):
            torque[at] += offset

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [
            {"forward": f * scales.torque, "backward": b * scales.torque}
            for f, b in ((0.03, 0.01), (0.01, 0.03), (0.3, 0.1), (0.1, 0.3), (1.0, 0.5), (0.5, 1.0))
        ]
