"""A motor that follows its torque command with a lag."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class ActuatorBandwidth(Effect):
    """τ̇ = ω (τ_command − τ)."""

    name = "actuator_bandwidth"
    title = "actuator bandwidth"
    parameters = (
        Parameter("cutoff", "Hz", 0.5, 500.0, "corner frequency", neutral=np.inf, log=True),
    )
    summary = "the motor torque follows its command with a first-order lag"
    signature = "the loop is less damped than its gains say: it overshoots and rings"
    source = "first-order lag, averaged exactly over each period of the loop"
    follows = "velocity"
    order = 30

    def install(self, loop, rows, joints, values):
        ticks = 2 * np.pi * values["cutoff"] * loop.period_s
        keep = np.exp(-ticks)
        mean = -np.expm1(-ticks) / ticks
        state, at = {}, (rows, loop.columns(joints))

        def change(tick, torque):
            command = torque[at].copy()
            gap = state.get("torque", command) - command
            torque[at] = command + gap * mean
            state["torque"] = command + gap * keep

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"cutoff": f * one} for f in (3.0, 10.0, 30.0, 100.0)]
