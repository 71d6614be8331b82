"""Torque that reaches the motor late."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.effects.loop_signals import delayed
from t2l.sim.delay import DelayLine
from t2l.sim.loop import over_ticks


class TorqueDelay(Effect):
    """τ(t) → τ(t − d), gravity compensation of the loop included."""

    name = "torque_delay"
    title = "torque delay"
    parameters = (
        Parameter("delay", "s", 0.0, 0.1, "time from controller to motor", per_joint=False),
    )
    summary = "what the controller computes reaches the motor late: a bus between both"
    signature = "the loop is less damped than its gains say, most where they are high"
    source = "Åström and Wittenmark, Computer-controlled systems, 1997, chapter 2: delayed input"
    follows = "velocity"
    order = 5  # what a slower loop holds is sent

    def export(self, to, joints, values):
        to.call(self.name, send_torque_late, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        late, at = DelayLine(values["delay"] / loop.period_s), (..., rows, loop.columns(joints))

        @over_ticks
        def change(tick, torque):
            torque[at] = late(torque[at])

        loop.controller_filters.append(change)

    def starts(self, scales):
        return [{"delay": np.array([d])} for d in (0.001, 0.002, 0.005, 0.01, 0.02)]


def send_torque_late(robot, joints, values):
    """Let the motor get what the controller computed before."""
    past = robot.state.setdefault("past", [])
    robot.motor[joints] = delayed(past, robot.motor[joints], values["delay"] / robot.period_s)
