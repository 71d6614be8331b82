"""Motor torque off by a factor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class TorqueConstant(Effect):
    """τ_motor → k τ_motor, gravity compensation included."""

    name = "torque_constant"
    title = "torque-constant error"
    parameters = (
        Parameter(
            "factor", "1", 0.1, 5.0, "delivered torque over commanded", neutral=1.0, log=True
        ),
    )
    summary = "the motor delivers a fixed fraction of the commanded torque, gravity's part too"
    signature = "the error follows the commanded torque"
    source = "τ = k_t i with a wrong k_t"
    follows = "torque"
    order = 40

    def export(self, to, joints, values):
        to.kp[joints] *= values["factor"]
        to.kd[joints] *= values["factor"]
        to.limit[joints] *= values["factor"]
        if to.gravity_compensation:
            to.call(self.name, scale_gravity_compensation, joints, values)

    def install(self, loop, rows, joints, values):
        at = rows, loop.columns(joints)

        def change(tick, torque):
            torque[at] *= values["factor"]

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"factor": factor * one} for factor in (0.95, 0.8, 0.6, 1.1, 1.3)]


def scale_gravity_compensation(robot, joints, values):
    """Let the motor deliver its fraction of gravity's torque too."""
    robot.torque[joints] += (values["factor"] - 1) * robot.gravity[joints]
