"""Reflected inertia of motor and gearbox."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class Armature(Effect):
    """(M + diag(Δ)) q̈ = …: rotor inertia times gear ratio squared."""

    name = "armature"
    title = "armature"
    parameters = (
        Parameter(
            "inertia",
            "kg·m²",
            -2.0,
            20.0,
            "reflected inertia added to the MJCF's armature",
            adds_to="dof_armature",
        ),
    )
    summary = "inertia of rotor and gears, reflected through the gear ratio squared"
    signature = "the error follows the acceleration"
    source = "MuJoCo, XML reference, joint/armature"
    follows = "acceleration"

    def export(self, to, joints, values):
        for joint, inertia in zip(to.each(joints), values["inertia"], strict=True):
            joint.armature = max(joint.armature + inertia, 0.0)

    def install(self, loop, rows, joints, values):
        loop.inertia_changed = True
        field, dofs = loop.batch.expand("dof_armature"), loop.dofs[joints]
        field[rows, dofs] = np.maximum(field[rows, dofs] + values["inertia"], 0.0)

    def starts(self, scales):
        return [
            *({"inertia": factor * scales.inertia} for factor in (0.02, 0.1, 0.5)),
            {"inertia": -0.3 * scales.armature},
        ]
