"""Measurements stamped by another clock than the commands."""

import numpy as np

from t2l.effects.effect import Effect, Parameter


class ClockOffset(Effect):
    """A sample stamped t was taken at t − δ, with δ ≤ 0: it answers to commands still to come."""

    name = "clock_offset"
    title = "clock offset"
    parameters = (
        Parameter(
            "offset", "s", -0.3, 0.0, "stamp of a measurement minus that of a command at once",
            per_joint=False,
        ),
    )  # fmt: skip
    summary = (
        "measurements are stamped earlier than the commands that they answer; stamped later, they "
        "cannot be told from a command delay"
    )
    signature = "the robot seems to answer before it is asked, by a time that is alike at all gains"
    source = "q_des(t − δ): commands lead by whole ticks of the loop, samples are later by the rest"
    follows = "command velocity"

    def export(self, to, joints, values):
        to.of_log.append(self.name)
        to.log_lead_s -= values["offset"]

    def install(self, loop, rows, joints, values):
        loop.command_lead_s[rows, joints] -= values["offset"]

    def starts(self, scales):
        return [{"offset": np.array([-d])} for d in (0.002, 0.005, 0.01, 0.02, 0.04, 0.08)]
