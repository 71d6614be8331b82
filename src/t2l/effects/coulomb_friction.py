"""Dry friction of constant size."""

import math

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import Exported
from t2l.sim.dry_friction import HOLDS, make_room


class CoulombFriction(Effect):
    """τ = −Fc sign(q̇), and up to Fc whatever holds a joint at rest."""

    name = "coulomb_friction"
    title = "Coulomb friction"
    parameters = (
        Parameter(
            "torque",
            "N·m",
            -math.inf,
            10.0,
            "friction torque added to the MJCF's frictionloss",
            adds_to="dof_frictionloss",
            kinked=True,
            scale="torque",
        ),
    )
    summary = "dry friction: a constant torque against the motion that holds the joint at rest"
    signature = "the error follows the direction of motion and jumps at reversals"
    source = "MuJoCo, XML reference, joint/frictionloss"
    remembers = False
    follows = "direction"

    def export(self, to, joints, values):
        export_friction(to, joints, values["torque"])

    def install(self, loop, rows, joints, values):
        loop.added_friction[rows, joints] += values["torque"]

    def starts(self, scales):
        return [
            *({"torque": factor * scales.torque} for factor in (0.01, 0.05, 0.3, 1.0)),
            {"torque": -0.3 * scales.friction},
        ]


def export_friction(to: Exported, joints: np.ndarray, added: np.ndarray) -> None:
    """Write dry friction of `added` (k,) N·m beside the MJCF's own, of which it may take away."""
    stiffest = 2 * to.period_s
    for j, joint, torque in zip(joints, to.each(joints), added, strict=True):
        own = joint.frictionloss
        if own > 0:
            make_room(to.spec, (to.joints[j],))
            joint.frictionloss = max(own + min(torque, 0.0), 0.0)
            element = to.spec.tendon(f"{to.joints[j]}/friction")
            element.frictionloss = max(torque, 0.0)
        else:
            element = joint
            joint.frictionloss = max(torque, 0.0)
        element.solimp_friction[:2] = HOLDS
        element.solref_friction[0] = stiffest
