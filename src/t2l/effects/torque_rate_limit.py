"""A motor torque that cannot change faster than a limit."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class TorqueRateLimit(Effect):
    """|τ_k − τ_{k−1}| ≤ rate · period."""

    name = "torque_rate_limit"
    title = "torque-rate limit"
    parameters = (
        Parameter("rate", "N·m/s", 0.01, 1e5, "fastest change of torque", neutral=np.inf, log=True),
    )
    summary = "the motor torque changes no faster than a rate"
    signature = "the error appears after steps of the command, where the torque changes fastest"
    source = "slew limit on the motor torque"
    follows = "torque rate"
    order = 15

    def install(self, loop, rows, joints, values):
        largest = values["rate"] * loop.period_s
        state = {}

        def change(tick, torque):
            command = torque[rows, joints]
            last = state.get("torque", command)
            state["torque"] = last + np.clip(command - last, -largest, largest)
            torque[rows, joints] = state["torque"]

        loop.motor_filters.append(change)

    def starts(self, scales):
        return [
            {"rate": f * scales.peak_torque_rate} for f in (0.5, 0.15, 0.05, 0.015, 0.005, 0.0015)
        ]
