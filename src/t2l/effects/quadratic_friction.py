"""Friction that grows with the square of velocity."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import over_ticks


class QuadraticFriction(Effect):
    """τ = −c q̇ |q̇|."""

    name = "quadratic_friction"
    title = "quadratic friction"
    parameters = (
        Parameter(
            "coefficient", "N·m·s²/rad²", 0.0, 10.0, "torque at 1 rad/s",
            scale="(kd + torque / velocity) / velocity",
        ),
    )  # fmt: skip
    summary = "friction that grows with the square of velocity, as of churning oil and air"
    signature = "the error follows the square of the velocity and vanishes in slow motion"
    source = "MuJoCo, XML reference, joint/damping, second coefficient"
    remembers = False
    follows = "velocity squared"

    def export(self, to, joints, values):
        for joint, coefficient in zip(to.each(joints), values["coefficient"], strict=True):
            joint.damping[1] += coefficient

    def install(self, loop, rows, joints, values):
        coefficient = values["coefficient"]
        drag = loop.in_motion(
            rows, joints, lambda tick, torque, dq: torque - coefficient * dq * np.abs(dq)
        )

        @over_ticks
        def add(tick, q, dq, torque):
            drag(tick, torque)

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [{"coefficient": factor * scales.kd / scales.velocity} for factor in (0.02, 0.2)]
