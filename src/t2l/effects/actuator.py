"""A joint's actuator in place of what the MJCF says of it: what is fitted under known gains.

It is no effect that a model may lack, and so not among those that `t2l effects` lists.
"""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.dry_friction import HOLDS

# guess: of any joint of an arm
GUESS = {
    "armature": 0.1, "friction": 0.5, "viscous_friction": 0.5, "torque_offset": 0.0,
    "torque_scale": 1.0,
}  # fmt: skip


class Actuator(Effect):
    """τ = k (Kp (q_des − q) − Kd q̇) + τ0 on an armature, with Coulomb and viscous friction.

    Bounds are so wide that no arm reaches them.
    """

    name = "actuator"
    title = "actuator"
    parameters = (
        Parameter("armature", "kg·m²", 0.0, 10.0, "rotor inertia seen at the joint", size=0.05),
        Parameter("friction", "N·m", 0.0, 100.0, "Coulomb friction", size=0.3),
        Parameter("viscous_friction", "N·m·s/rad", 0.0, 100.0, "torque by velocity", size=0.3),
        Parameter("torque_offset", "N·m", -100.0, 100.0, "what compensation leaves", size=0.1),
        Parameter("torque_scale", "1", 0.1, 10.0, "torque over what the gains say", log=True),
    )
    summary = "the joint's own inertia and friction, and how much of the torque it delivers"
    signature = "it is fitted whole"
    source = "MuJoCo, XML reference, joint; τ = k_t i with an unknown k_t"
    remembers = False

    def install(self, loop, rows, joints, values):
        batch, dofs = loop.batch, loop.dofs[joints]
        batch.expand("dof_armature")[rows, dofs] = values["armature"]
        batch.expand("dof_damping")[rows, dofs] = values["viscous_friction"]
        batch.expand("dof_frictionloss")[rows, dofs] = values["friction"]
        # the MJCF's own softness plays no part
        batch.expand("dof_solimp")[rows, dofs, :2] = HOLDS
        batch.expand("dof_solref")[rows, dofs, 0] = 2 * batch.model.opt.timestep
        loop.kp[rows, joints] *= values["torque_scale"]
        loop.kd[rows, joints] *= values["torque_scale"]
        loop.inertia_changed = True
        at = rows, loop.columns(joints)

        def add(tick, q, dq, torque):
            torque[at] += values["torque_offset"]

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [{name: np.full_like(scales.torque, value) for name, value in GUESS.items()}]
