"""Motor torque off by a factor."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks


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
    remembers = False
    follows = "torque"
    order = 40

    def export(self, to, joints, values):
        def scale():
            to.kp[joints] *= values["factor"]
            to.kd[joints] *= values["factor"]
            to.limit[joints] *= values["factor"]

        # MuJoCo compensates gravity whole, whatever the gains
        element = None if to.gravity_compensation else scale
        to.call(self.name, scale_torque, joints, values, MOTOR, element)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            torque[at] *= values["factor"]

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"factor": factor * one} for factor in (0.95, 0.8, 0.6, 1.1, 1.3)]


def scale_torque(robot, joints, values):
    """Let the motor deliver its fraction of all torque."""
    robot.motor[joints] *= values["factor"]
