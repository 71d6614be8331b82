"""A motor torque that cannot exceed a limit."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks


class TorqueSaturation(Effect):
    """τ → clip(τ, −τ_max, τ_max)."""

    name = "torque_saturation"
    title = "torque saturation"
    parameters = (
        Parameter(
            "limit", "N·m", 1e-3, 100.0, "largest motor torque", neutral=np.inf, log=True,
            scale="peak_torque",
        ),
    )  # fmt: skip
    summary = "the motor torque is cut at a limit, gravity compensation included"
    signature = "the error appears where the commanded torque is largest, and nowhere else"
    source = "clip(τ, ±τ_max)"
    remembers = False
    follows = "torque"
    order = 20

    def export(self, to, joints, values):
        def limit():
            to.limit[joints] = np.minimum(to.limit[joints], values["limit"])

        both = {"low": -values["limit"], "high": values["limit"]}
        to.call(self.name, cut_torque, joints, both, MOTOR, element=limit)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            torque[at] = np.minimum(np.maximum(torque[at], -values["limit"]), values["limit"])

        loop.motor_filters.append(change)

    def starts(self, scales):
        return [
            {"limit": f * scales.peak_torque} for f in (0.9, 0.75, 0.55, 0.35, 0.2, 0.1, 0.05, 0.02)
        ]


def cut_torque(robot, joints, values):
    """Cut the motor torque at its limits."""
    motor = np.maximum(robot.motor[joints], values["low"])
    robot.motor[joints] = np.minimum(motor, values["high"])
