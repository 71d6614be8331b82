"""Commands that arrive late."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class CommandDelay(Effect):
    """q_des(t) → q_des(t − d), and likewise velocity and torque where they are commanded."""

    name = "command_delay"
    title = "command delay"
    parameters = (
        Parameter(
            "delay", "s", 0.0, 0.3, "time from command to controller", kinked=True, per_joint=False
        ),
    )
    summary = "commands reach the controller late: network, bus, interpolation"
    signature = "the response is the model's shifted in time, alike at all gains"
    source = "q_des(t − d) by the stamps of the commands; linear between ticks if all are at ticks"
    remembers = False
    acts_through = ("kp", "kd")
    follows = "command velocity"

    def export(self, to, joints, values):
        to.delay_s[joints] += values["delay"]

    def install(self, loop, rows, joints, values):
        loop.command_delay_s[rows, joints] += values["delay"]

    def starts(self, scales):
        return [{"delay": np.array([d])} for d in (0.002, 0.005, 0.01, 0.02, 0.04, 0.08)]
