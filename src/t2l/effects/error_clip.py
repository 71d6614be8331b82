"""A controller that limits the position error it reacts to."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.effects.loop_signals import error_at, error_of_torque
from t2l.sim.loop import over_ticks


class ErrorClip(Effect):
    """Kp e → Kp clip(e, −L, L), with the position error e."""

    name = "error_clip"
    title = "limited position error"
    parameters = (
        Parameter(
            "limit", "rad", 1e-4, 10.0, "largest error that the controller sees, L",
            neutral=np.inf, log=True,
        ),
    )  # fmt: skip
    summary = "the controller cuts the position error at a limit before Kp multiplies it"
    signature = "large errors get no more torque than the limit times Kp, with damping as before"
    source = "LinuxCNC, HAL component pid: maxerror"
    acts_through = ("kp",)
    remembers = False
    follows = "torque"
    order = -20

    def export(self, to, joints, values):
        to.call(self.name, cut_error, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        at, limit = (..., rows, loop.columns(joints)), values["limit"]

        @over_ticks
        def change(tick, torque):
            error = error_at(loop, at)
            torque[at] -= loop.kp[at] * (error - np.minimum(np.maximum(error, -limit), limit))

        loop.controller_filters.append(change)

    def starts(self, scales):
        largest = error_of_torque(scales.peak_torque, scales.kp)
        return [
            {"limit": np.clip(f * largest, 1e-4, 10.0)} for f in (0.05, 0.1, 0.2, 0.4, 0.75, 1.5)
        ]


def cut_error(robot, joints, values):
    """Take away what a controller makes of a position error beyond its limit."""
    error = robot.target[joints] - robot.q[joints]
    beyond = error - np.clip(error, -values["limit"], values["limit"])
    robot.motor[joints] -= robot.kp[joints] * beyond
