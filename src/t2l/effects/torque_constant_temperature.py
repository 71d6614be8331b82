"""A motor whose torque follows the logged temperature."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.warming import REFERENCE_C
from t2l.sim.loop import over_ticks


class TorqueConstantTemperature(Effect):
    """τ_motor → k (1 + α (θ − 25 °C)) τ_motor."""

    name = "torque_constant_temperature"
    title = "torque constant that follows temperature"
    parameters = (
        Parameter("factor", "1", 0.1, 5.0, "delivered over commanded, 25 °C, k", 1.0, log=True),
        Parameter("per_kelvin", "1/K", -0.02, 0.02, "change of it, α", size=1e-3),
    )
    summary = "the motor delivers less of the commanded torque the warmer it is"
    signature = "the error follows the commanded torque, by more the warmer the motor is"
    source = "remanence of magnets falls by 0.1 to 0.2 % a kelvin"
    remembers = False
    contains = ("torque_constant",)
    follows = "torque"
    needs = ("temperature",)
    order = 40

    def export(self, to, joints, values):
        to.cannot_carry(self.name, "a simulator has no temperature")

    def install(self, loop, rows, joints, values):
        here = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            warmer = loop.logged("temperature", tick, self.name)[here] - REFERENCE_C
            share = np.maximum(1 + values["per_kelvin"] * warmer, 0.0)
            torque[here] *= values["factor"] * share

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"factor": factor * one, "per_kelvin": slope * one}
            for factor, slope in ((1.0, -0.002), (1.0, -0.01), (1.0, 0.005), (0.9, -0.002))
        ]
