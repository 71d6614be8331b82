"""Dry friction that bends like a spring before it slips."""

import numpy as np

from t2l.effects.bristles import add_bristles, install_bristles
from t2l.effects.effect import Effect, Parameter


class DahlFriction(Effect):
    """dF/dq = σ0 (1 − F sign(q̇) / Fc), with σ0 = Fc / δ and τ = −F."""

    name = "dahl_friction"
    title = "Dahl friction"
    parameters = (
        Parameter(
            "coulomb", "N·m", 0.0, 10.0, "friction in steady motion beside the MJCF's, Fc",
            scale="torque",
        ),
        Parameter("presliding", "rad", 1e-5, 1.0, "deflection at which σ0 would slip, δ", log=True),
    )  # fmt: skip
    summary = "dry friction of bristles, seals or belts that give elastically before they slip"
    signature = "the error follows the direction of motion, and eases in after each reversal"
    source = "Dahl, A solid friction model, 1968, with exponent 1"
    contains = ("coulomb_friction",)
    follows = "direction"
    holds_torque = True
    order = 50  # at the start bristles hold what all other torques leave

    def export(self, to, joints, values):
        to.call(self.name, bend_then_slip, joints, values)

    def held(self, values):
        return values["coulomb"], values["presliding"]

    def install(self, loop, rows, joints, values):
        coulomb = values["coulomb"]
        install_bristles(loop, rows, joints, coulomb / values["presliding"], lambda dq: coulomb)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"coulomb": f * scales.torque, "presliding": d * one}
            for f in (0.05, 0.5)
            for d in (3e-4, 3e-3, 3e-2)
        ]


def bend_then_slip(robot, joints, values):
    """Add bristles that slip at one level."""
    coulomb = values["coulomb"]
    add_bristles(robot, joints, coulomb / values["presliding"], coulomb, 0.0)
