"""Commands that a low-pass smooths."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.sim.loop import each_tick, over_ticks


class CommandFilter(Effect):
    """ẋ = ω (q_des − x), the controller follows x; likewise velocity and torque commands."""

    name = "command_filter"
    title = "command low-pass"
    parameters = (
        Parameter(
            "cutoff", "Hz", 0.3, 300.0, "corner frequency", neutral=np.inf, log=True,
            per_joint=False,
        ),
    )  # fmt: skip
    summary = "the robot smooths commands by a first-order low-pass"
    signature = "the response is the model's, later and smaller the faster the command"
    source = "first-order low-pass, exact for a held command"
    acts_through = ("kp", "kd")
    follows = "command velocity"
    order = 10

    def export(self, to, joints, values):
        to.lowpass_s[joints] += 1 / (2 * np.pi * values["cutoff"])

    def install(self, loop, rows, joints, values):
        keep = np.exp(-2 * np.pi * values["cutoff"] * loop.period_s)
        at = rows, loop.columns(joints)
        for filters in (loop.command_filters, loop.feed_forward_filters):
            filters.append(_low_pass(keep, at))

    def starts(self, scales):
        return [{"cutoff": np.array([f])} for f in (1.0, 3.0, 10.0, 30.0)]


def _low_pass(keep, at):
    state = {}

    @over_ticks
    def change(tick, command):
        for now in each_tick(command):
            raw = now[at].copy()
            value = raw + (state.get("x", raw) - raw) * keep
            state["x"] = now[at] = value

    return change
