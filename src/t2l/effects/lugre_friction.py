"""Bristles whose friction falls from a breakaway torque to a lower level in motion."""

import numpy as np

from t2l.effects.bristles import add_bristles, install_bristles
from t2l.effects.effect import Effect, Parameter


class LugreFriction(Effect):
    """ż = q̇ − σ0 |q̇| z / g, τ = −(σ0 z + σ1 ż), g = Fc + Fs exp(−(q̇/vs)²), σ0 = (Fc + Fs) / δ."""

    name = "lugre_friction"
    title = "LuGre friction"
    parameters = (
        Parameter(
            "coulomb", "N·m", 0.0, 10.0, "friction in fast motion beside the MJCF's, Fc",
            scale="torque",
        ),
        Parameter(
            "extra_at_rest", "N·m", 0.0, 10.0, "by how much breakaway exceeds it, Fs",
            scale="torque",
        ),
        Parameter(
            "velocity", "rad/s", 0.003, 10.0, "where the excess fades, vs", log=True,
            scale="velocity",
        ),
        Parameter("presliding", "rad", 1e-5, 1.0, "deflection of breakaway, δ", log=True),
        Parameter(
            "damping", "N·m·s/rad", 1e-3, 1e3, "of the bristles, σ1", log=True,
            scale="sqrt(torque * inertia)",
        ),
    )  # fmt: skip
    summary = "dry friction of bristles that bend before they slip, and slip easier in motion"
    signature = "the error is largest in slow motion, and eases in after each reversal"
    source = "Canudas de Wit et al., A new model for control of systems with friction, 1995"
    contains = ("coulomb_friction", "stribeck_friction", "dahl_friction")
    follows = "direction"
    holds_torque = True
    order = 50

    def export(self, to, joints, values):
        to.call(self.name, bend_then_slip_easier, joints, values)

    def held(self, values):
        return values["coulomb"] + values["extra_at_rest"], values["presliding"]

    def install(self, loop, rows, joints, values):
        coulomb, extra = values["coulomb"], values["extra_at_rest"]
        stiffness = (coulomb + extra) / values["presliding"]

        def level(dq):
            return level_in_motion(dq, coulomb, extra, values["velocity"])

        felt = np.where(coulomb + extra > 0, values["damping"], 0.0)
        install_bristles(loop, rows, joints, stiffness, level, felt)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {
                "coulomb": f * scales.torque,
                "extra_at_rest": f * scales.torque,
                "velocity": 0.2 * scales.velocity,
                "presliding": d * one,
                # a bristle of that stiffness, damped by 0.7
                "damping": 1.4 * np.sqrt(2 * f * scales.torque / d * scales.inertia),
            }
            for f in (0.02, 0.2)
            for d in (3e-4, 5e-3)
        ]


def level_in_motion(dq, coulomb, extra, velocity):
    """N·m at which bristles slip."""
    return coulomb + extra * np.exp(-((dq / velocity) ** 2))


def bend_then_slip_easier(robot, joints, values):
    """Add bristles that slip at a lower level in motion."""
    coulomb, extra = values["coulomb"], values["extra_at_rest"]
    level = level_in_motion(robot.velocity[joints], coulomb, extra, values["velocity"])
    felt = np.where(coulomb + extra > 0, values["damping"], 0.0)
    add_bristles(robot, joints, (coulomb + extra) / values["presliding"], level, felt)
