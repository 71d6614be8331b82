"""A controller that takes a small position error for none."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.effects.loop_signals import error_at, error_of_torque
from t2l.sim.loop import over_ticks


class ErrorDeadBand(Effect):
    """Kp e → Kp (e − clip(e, −b, b)), with the position error e."""

    name = "error_dead_band"
    title = "dead band of the position error"
    parameters = (
        Parameter("band", "rad", 0.0, 0.5, "largest error that gives no torque, b", kinked=True),
    )
    summary = "a position error within a band gives no torque, a larger one that of what is beyond"
    signature = "the joint stops short of its command by up to the band, most at low gains"
    source = "LinuxCNC, HAL component pid: deadband; ROBOTIS AX-12A e-Manual: compliance margin"
    acts_through = ("kp",)
    remembers = False
    follows = "torque"
    order = -20  # the integral, the loop's rate and all else act on what is left

    def export(self, to, joints, values):
        to.call(self.name, ignore_small_error, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        at, band = (..., rows, loop.columns(joints)), values["band"]

        @over_ticks
        def change(tick, torque):
            torque[at] -= loop.kp[at] * np.minimum(np.maximum(error_at(loop, at), -band), band)

        loop.controller_filters.append(change)

    def starts(self, scales):
        usual = error_of_torque(scales.torque, scales.kp)
        return [{"band": np.minimum(f * usual, 0.4)} for f in (0.03, 0.1, 0.3, 1.0)]


def ignore_small_error(robot, joints, values):
    """Take away what a controller makes of a position error within a band."""
    error = robot.target[joints] - robot.q[joints]
    ignored = np.clip(error, -values["band"], values["band"])
    robot.motor[joints] -= robot.kp[joints] * ignored
