"""Reflected inertia of motor and gearbox."""

import math
from collections.abc import Sequence

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import Exported
from t2l.sim.servo import ServoLoop

# bound: of a joint's inertia, by which links may be lighter: in other poses there may be less of it
LIGHTEST = 0.5


class Armature(Effect):
    """(M + diag(Δ)) q̈ = …: rotor inertia times gear ratio squared."""

    name = "armature"
    title = "armature"
    parameters = (
        Parameter(
            "inertia",
            "kg·m²",
            -math.inf,
            300.0,
            "reflected inertia added to the MJCF's armature",
            adds_to="dof_armature",
            scale="inertia",
        ),
    )
    summary = "inertia of rotor and gears, reflected through the gear ratio squared"
    signature = "the error follows the acceleration"
    source = "MuJoCo, XML reference, joint/armature"
    remembers = False
    follows = "acceleration"

    def export(self, to, joints, values):
        export_armature(to, joints, values["inertia"])

    def install(self, loop, rows, joints, values):
        add_armature(loop, rows, joints, values["inertia"])

    def starts(self, scales):
        return [
            *({"inertia": factor * scales.inertia} for factor in (0.02, 0.1, 0.5)),
            {"inertia": -0.3 * scales.armature},
        ]


def add_armature(
    loop: ServoLoop, rows: slice, joints: np.ndarray, inertia: np.ndarray, lightest: float = 0.0
) -> None:
    """Let joints be heavier to turn by `inertia` (nrow, njoint) kg·m²; below none there is none.

    Args:
        lightest: of a joint's whole inertia, what may go beyond its armature.
    """
    loop.inertia_changed = True
    field, dofs = loop.batch.expand("dof_armature"), loop.dofs[joints]
    # 1/(M⁻¹)_jj, with the other joints free
    whole = 1 / loop.batch.model.dof_invweight0[dofs]
    # what a lighter link took away before stays away
    least = np.minimum(field[rows, dofs] - lightest * whole, 0.0)
    field[rows, dofs] = np.maximum(field[rows, dofs] + inertia, least)


def export_armature(to: Exported, joints: np.ndarray, inertia: Sequence[float]) -> None:
    """The same in a model for other simulators."""
    for joint, more in zip(to.each(joints), inertia, strict=True):
        joint.armature = max(joint.armature + more, 0.0)
