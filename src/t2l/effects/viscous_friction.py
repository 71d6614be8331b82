"""Friction proportional to velocity."""

import math

import numpy as np

from t2l.effects.effect import Effect, Parameter


class ViscousFriction(Effect):
    """τ = −b q̇."""

    name = "viscous_friction"
    title = "viscous friction"
    parameters = (
        Parameter(
            "damping",
            "N·m·s/rad",
            -math.inf,
            10.0,
            "damping added to the MJCF's",
            adds_to="dof_damping",
            scale="kd + torque / velocity",
        ),
    )
    summary = "friction proportional to velocity, as of grease and back-EMF"
    signature = "the error follows the velocity, in proportion"
    source = "MuJoCo, XML reference, joint/damping"
    remembers = False
    follows = "velocity"

    def export(self, to, joints, values):
        for joint, damping in zip(to.each(joints), values["damping"], strict=True):
            joint.damping[0] = max(joint.damping[0] + damping, 0.0)

    def install(self, loop, rows, joints, values):
        field, dofs = loop.batch.expand("dof_damping"), loop.dofs[joints]
        field[rows, dofs] = np.maximum(field[rows, dofs] + values["damping"], 0.0)

    def starts(self, scales):
        return [
            *({"damping": factor * scales.kd} for factor in (0.01, 0.05, 0.4)),
            {"damping": -0.3 * scales.damping},
        ]
