"""A control loop that runs slower than the log says."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.sim.loop import over_ticks


class LowRateLoop(Effect):
    """What the loop computes, gravity compensation included, is renewed at a lower rate."""

    name = "low_rate_loop"
    title = "low-rate control loop"
    parameters = (
        Parameter(
            "rate", "Hz", 10.0, 1e4, "rate of the loop", neutral=np.inf, log=True,
            per_joint=False, rough=True,
        ),
        Parameter(
            "phase", "1", 0.0, 1.0, "part of its period that has passed where a log begins",
            neutral=np.nan, per_joint=False, rough=True, size=1.0,
        ),
    )  # fmt: skip
    summary = "the control loop runs slower than the log says and holds its torque longer"
    signature = "stiff, damped gains ring and chatter, compliant ones do not"
    source = "zero-order hold; to first order Kd − Kp·h/2 for a period h"
    follows = "velocity"

    def export(self, to, joints, values):
        to.call(self.name, renew_at_lower_rate, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        per_tick = values["rate"] * loop.period_s
        held = 1.0 / values["rate"]
        late = np.maximum(held, loop.period_s) - np.maximum(held, loop.real_period_s)
        loop.ahead[rows] = late / 2
        state, at = {}, (..., rows, loop.columns(joints))

        @over_ticks
        def change(tick, torque):
            periods = np.asarray(tick)[..., None, None] * per_tick + values["phase"]
            torque[at] = renewed(torque[at].copy(), state, periods, per_tick)

        loop.controller_filters.append(change)

    def starts(self, scales):
        divisors = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 33, 50)
        rates = [scales.control_rate_hz / d for d in divisors]
        return [
            {"rate": np.array([rate]), "phase": np.array([phase])}
            for rate in rates if rate >= 10.0
            for phase in (0.0, 0.5)
        ]  # fmt: skip


def renewed(command, state, periods, per_tick):
    """The command, N·m, of the last tick at which it was due; `state` keeps it.

    Args:
        command: (n, njoint), or (k, n, njoint) of ticks that follow each other.
        periods: of the slow loop that have passed, of which a tick is `per_tick`.
    """
    # numerics: what is due now is not missed by rounding
    due = np.floor(periods + 1e-6) > np.floor(periods - per_tick + 1e-6)
    if command.ndim < 3:
        state["torque"] = np.where(due, command, state.get("torque", command))
        return state["torque"]
    before = state.get("torque", command[0])
    place = np.where(due, np.arange(1, 1 + len(command))[:, None, None], 0)
    last = np.maximum.accumulate(np.broadcast_to(place, command.shape), axis=0)
    held = np.take_along_axis(np.concatenate([before[None], command]), last, axis=0)
    state["torque"] = held[-1]
    return held


def renew_at_lower_rate(robot, joints, values):
    """Hold what the loop computes between the ticks of a slower one."""
    per_tick = values["rate"] * robot.period_s
    periods = robot.tick * per_tick + values["phase"]
    robot.motor[joints] = renewed(robot.motor[joints], robot.state, periods, per_tick)
