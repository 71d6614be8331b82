"""Friction that grows with the square of velocity."""

from t2l.effects.effect import Effect, Parameter


class QuadraticFriction(Effect):
    """τ = −c q̇ |q̇|."""

    name = "quadratic_friction"
    title = "quadratic friction"
    parameters = (Parameter("coefficient", "N·m·s²/rad²", 0.0, 100.0, "torque at 1 rad/s"),)
    summary = "friction that grows with the square of velocity, as of churning oil and air"
    signature = "the error follows the square of the velocity and vanishes in slow motion"
    source = "MuJoCo, XML reference, joint/damping, second coefficient"
    remembers = False
    follows = "velocity squared"

    def export(self, to, joints, values):
        for joint, coefficient in zip(to.each(joints), values["coefficient"], strict=True):
            joint.damping[1] += coefficient

    def install(self, loop, rows, joints, values):
        loop.batch.expand("dof_dampingpoly")[rows, loop.dofs[joints], 0] += values["coefficient"]

    def starts(self, scales):
        speed = scales.velocity + 1e-3
        return [{"coefficient": factor * scales.kd / speed} for factor in (0.02, 0.2)]
