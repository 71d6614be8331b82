"""Dry friction of constant size."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import Exported
from t2l.sim.servo import ServoLoop

HOLDS = 0.9999  # constraint impedance; MuJoCo's default of 0.9 lets a joint at rest creep


class CoulombFriction(Effect):
    """τ = −Fc sign(q̇), and up to Fc whatever holds a joint at rest."""

    name = "coulomb_friction"
    title = "Coulomb friction"
    parameters = (
        Parameter(
            "torque",
            "N·m",
            -20.0,
            50.0,
            "friction torque added to the MJCF's frictionloss",
            adds_to="dof_frictionloss",
        ),
    )
    summary = "dry friction: a constant torque against the motion that holds the joint at rest"
    signature = "the error follows the direction of motion and jumps at reversals"
    source = "MuJoCo, XML reference, joint/frictionloss"
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, values["torque"])

    def install(self, loop, rows, joints, values):
        field, dofs = loop.batch.expand("dof_frictionloss"), loop.dofs[joints]
        field[rows, dofs] = np.maximum(field[rows, dofs] + values["torque"], 0.0)
        hold_at_rest(loop, rows, joints, values["torque"])

    def starts(self, scales):
        return [
            *({"torque": factor * scales.torque} for factor in (0.01, 0.05, 0.3, 1.0)),
            {"torque": -0.3 * scales.friction},
        ]


def hold_at_rest(loop: ServoLoop, rows: slice, joints: np.ndarray, added: np.ndarray) -> None:
    """Let friction hold `joints` at rest, the more of it is `added` (nrow, k) to the MJCF's own.

    What the MJCF states keeps its own softness, which lets a joint at rest creep.
    """
    dofs, batch = loop.dofs[joints], loop.batch
    own = batch.model.dof_frictionloss[dofs]
    added = np.maximum(added, 0.0)
    part = np.where(own > 0, added / (own + added + 1e-12), 1.0)
    impedance, reference = batch.expand("dof_solimp"), batch.expand("dof_solref")
    for end in (0, 1):
        soft = 1 - batch.model.dof_solimp[dofs, end]
        impedance[rows, dofs, end] = 1 - soft ** (1 - part) * (1 - HOLDS) ** part
    # the stiffest that MuJoCo allows: velocity vanishes within a step
    stiffest = 2 * batch.model.opt.timestep
    time = np.maximum(batch.model.dof_solref[dofs, 0], stiffest)
    reference[rows, dofs, 0] = time ** (1 - part) * stiffest**part


def export_friction(to: Exported, joints: np.ndarray, added: np.ndarray) -> None:
    """Write dry friction that holds at rest as `hold_at_rest` does."""
    for joint, torque in zip(to.each(joints), added, strict=True):
        own, more = joint.frictionloss, max(torque, 0.0)
        part = more / (own + more + 1e-12) if own > 0 else 1.0
        for end in (0, 1):
            soft = 1 - joint.solimp_friction[end]
            joint.solimp_friction[end] = 1 - soft ** (1 - part) * (1 - HOLDS) ** part
        stiffest = 2 * to.period_s
        time = max(joint.solref_friction[0], stiffest)
        joint.solref_friction[0] = time ** (1 - part) * stiffest**part
        joint.frictionloss = max(own + torque, 0.0)
