"""A motor torque that cannot change faster than a limit."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import each_tick, over_ticks


class TorqueRateLimit(Effect):
    """|τ_k − τ_{k−1}| ≤ rate · period: in steps at the loop's ticks, or as a ramp between them."""

    name = "torque_rate_limit"
    title = "torque-rate limit"
    parameters = (
        Parameter(
            "rate", "N·m/s", 1e-5, 100.0, "fastest change of torque", neutral=np.inf, log=True,
            scale="peak_torque_rate",
        ),
        Parameter(
            "ramp", "1", 0.0, 1.0, "0: the controller limits its steps; 1: the drive ramps in time",
            per_joint=False,
        ),
    )  # fmt: skip
    summary = "the motor torque changes no faster than a rate"
    signature = "the error appears after steps of the command, where the torque changes fastest"
    source = "slew limit on the motor torque; a ramp is averaged exactly over each period"
    follows = "torque rate"
    order = 15
    every_s = 0.001  # numerics: a ramp is averaged over it

    def export(self, to, joints, values):
        to.call(self.name, limit_torque_rate, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        largest = values["rate"] * loop.plant_period_s
        delay = values["ramp"] / (2 * largest)
        state, at = {}, (rows, loop.columns(joints))

        @over_ticks
        def change(tick, torque):
            for now in each_tick(torque):
                now[at] = slewed(now[at].copy(), state, largest, delay)

        loop.motor_filters.append(change)

    def starts(self, scales):
        return [
            {"rate": f * scales.peak_torque_rate, "ramp": np.array([0.5])}
            for f in (5.0, 1.5, 0.5, 0.15, 0.05, 0.015, 0.005, 0.0015)
        ]


def slewed(command, state, largest, delay):
    """The mean torque of a period, N·m: `state` keeps its end, a step of the `largest` at most.

    Of a step s, a ramp lacks `delay` s |s| on average.
    """
    last = state.get("torque", command)
    step = np.minimum(np.maximum(command - last, -largest), largest)
    state["torque"] = last + step
    return last + step - delay * step * np.abs(step)


def limit_torque_rate(robot, joints, values):
    """Let the motor torque change no faster than its rate."""
    largest = values["rate"] * robot.period_s
    delay = values["ramp"] / (2 * largest)
    robot.motor[joints] = slewed(robot.motor[joints], robot.state, largest, delay)
