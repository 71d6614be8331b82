"""Dry friction of constant size."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.servo import ServoLoop

HOLDS = 0.9999  # constraint impedance; MuJoCo's default of 0.9 lets a joint at rest creep


class CoulombFriction(Effect):
    """τ = −Fc sign(q̇), and up to Fc whatever holds a joint at rest."""

    name = "coulomb_friction"
    title = "Coulomb friction"
    parameters = (
        Parameter("torque", "N·m", -20.0, 50.0, "friction torque added to the MJCF's frictionloss"),
    )
    summary = "dry friction: a constant torque against the motion that holds the joint at rest"
    signature = "the error follows the direction of motion and jumps at reversals"
    source = "MuJoCo, XML reference, joint/frictionloss"
    follows = "direction"

    def install(self, loop, rows, joints, values):
        field, dofs = loop.batch.expand("dof_frictionloss"), loop.dofs[joints]
        field[rows, dofs] = np.maximum(field[rows, dofs] + values["torque"], 0.0)
        hold_at_rest(loop, rows, joints)

    def starts(self, scales):
        return [
            *({"torque": factor * scales.torque} for factor in (0.01, 0.05, 0.3, 1.0)),
            {"torque": -0.3 * scales.friction},
        ]


def hold_at_rest(loop: ServoLoop, rows: slice, joints: np.ndarray) -> None:
    """Make the friction of `joints` hold them at rest instead of letting them creep."""
    dofs = loop.dofs[joints]
    loop.batch.expand("dof_solimp")[rows, dofs, :2] = HOLDS
    # the stiffest that refsafe allows: velocity vanishes within a step
    loop.batch.expand("dof_solref")[rows, dofs] = (2 * loop.batch.model.opt.timestep, 1.0)
