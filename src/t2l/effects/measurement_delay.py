"""Measurements that reach the controller late."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.effects.loop_signals import delayed
from t2l.sim.delay import DelayLine
from t2l.sim.loop import over_ticks


class MeasurementDelay(Effect):
    """The controller gets q(t − d) and q̇(t − d); the log holds q(t)."""

    name = "measurement_delay"
    title = "measurement delay"
    parameters = (
        Parameter("delay", "s", 0.0, 0.1, "time from encoder to controller", per_joint=False),
    )
    summary = "the controller acts on what the encoder read a while ago: a bus between both"
    signature = "the loop is less damped than its gains say, with commands in force at once"
    source = "Åström and Wittenmark, Computer-controlled systems, 1997, chapter 2: delayed output"
    acts_through = ("kp", "kd")
    follows = "velocity"
    order = -30

    def export(self, to, joints, values):
        to.call(self.name, measure_late, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        ticks, at = values["delay"] / loop.period_s, (..., rows, loop.columns(joints))
        late = DelayLine(ticks), DelayLine(ticks)

        @over_ticks
        def change(tick, q, dq):
            q[at], dq[at] = late[0](q[at]), late[1](dq[at])

        loop.feedback_filters.append(change)

    def starts(self, scales):
        return [{"delay": np.array([d])} for d in (0.001, 0.002, 0.005, 0.01, 0.02)]


def measure_late(robot, joints, values):
    """Let the controller act on what the encoder read before."""
    q, dq, ticks = robot.q[joints], robot.dq[joints], values["delay"] / robot.period_s
    past = robot.state.setdefault("q", []), robot.state.setdefault("dq", [])
    robot.motor[joints] += robot.kp[joints] * (q - delayed(past[0], q, ticks))
    robot.motor[joints] += robot.kd[joints] * (dq - delayed(past[1], dq, ticks))
