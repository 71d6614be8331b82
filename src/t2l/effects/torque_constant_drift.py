"""A motor that fades, or gains, as it runs."""

import numpy as np

from t2l.effects import warming
from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks


class TorqueConstantDrift(Effect):
    """τ_motor → k(t) τ_motor, with k(t) = k1 + (k0 − k1) e^(−t/T)."""

    name = "torque_constant_drift"
    title = "torque constant that drifts with time"
    parameters = (
        *(
            Parameter(
                f"at_{when}", "1", 0.1, 5.0, f"delivered torque over commanded at the {when}",
                neutral=1.0, log=True,
            )
            for when in ("start", "end")
        ),
        warming.TIME_CONSTANT,
    )  # fmt: skip
    summary = "the motor delivers less, or more, of the commanded torque as it warms up"
    signature = "the error follows the commanded torque, by a share that changes with time"
    source = "first-order warming; magnets and winding lose torque with temperature"
    remembers = False
    contains = ("torque_constant",)
    follows = "torque"
    order = 40

    def export(self, to, joints, values):
        to.call(self.name, torque_that_drifts, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        here = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            torque[here] *= warming.at(loop, rows, tick, values)

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"at_start": first * one, "at_end": last * one, "time_constant": np.array([time_s])}
            for time_s in warming.TIMES_S
            for first, last in ((1.0, 0.85), (0.85, 1.0))
        ]


def torque_that_drifts(robot, joints, values):
    """Let the motor deliver what it does by now."""
    left = np.exp(-(robot.data.time + 0.5 * robot.period_s) / values["time_constant"])
    robot.motor[joints] *= values["at_end"] + (values["at_start"] - values["at_end"]) * left
