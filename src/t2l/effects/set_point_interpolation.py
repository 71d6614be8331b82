"""Position commands that become ramps."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.effects.loop_signals import delayed
from t2l.sim.delay import DelayLine
from t2l.sim.loop import each_tick, over_ticks


class SetPointInterpolation(Effect):
    """x(t) = 1/T ∫ q_des from t − T to t: a step of the command becomes a ramp of T.

    With the time from command to command for T that is the straight line from one to the next.
    """

    name = "set_point_interpolation"
    title = "interpolated commands"
    parameters = (
        Parameter(
            "ramp", "s", 0.0, 0.5, "time in which a new command is reached, T", per_joint=False,
            size=0.005,
        ),
    )  # fmt: skip
    summary = "the robot goes from one position command to the next in a straight line over a time"
    signature = "the response is smoother than the model's, and later by half the ramp's time"
    source = "CiA 402 (IEC 61800-7-201), interpolated position mode: interpolation time period"
    acts_through = ("kp",)
    follows = "command velocity"
    order = 5  # commands that have arrived

    def export(self, to, joints, values):
        to.call(self.name, ramp_commands, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        at, period, state = (..., rows, loop.columns(joints)), loop.real_period_s, {}
        ramp = np.maximum(values["ramp"], period)
        before, several = DelayLine(ramp / period), loop.schedule.coarseness

        @over_ticks
        def change(tick, target):
            command = target[at]
            each = each_tick(command)
            if not state:
                state.update(first=each[0].copy(), sum=0.0 * each[0])
            # a tick may hold several of the real loop, of which the torque sees the mean
            more = np.repeat(each - state["first"], several, axis=0) * period
            sums = np.cumsum(np.concatenate([state["sum"][None], more]), axis=0)[1:]
            state["sum"] = sums[-1]
            steps = state["first"] + (sums - before(sums)) / ramp
            target[at] = (
                steps.reshape(-1, several, *each.shape[1:]).mean(axis=1).reshape(command.shape)
            )

        loop.command_filters.append(change)

    def starts(self, scales):
        return [{"ramp": np.array([t])} for t in (0.005, 0.01, 0.02, 0.04, 0.1)]


def ramp_commands(robot, joints, values):
    """Let the controller follow the mean of the commands over a time."""
    state, target = robot.state, robot.target[joints]
    period = robot.period_s
    ramp = np.maximum(values["ramp"], period)
    if not state:
        # before the first command the sum was zero
        state.update(first=target, sum=np.zeros(len(joints)), past=[])
    state["sum"] = state["sum"] + (target - state["first"]) * period
    before = delayed(state["past"], state["sum"], ramp / period)
    follow = state["first"] + (state["sum"] - before) / ramp
    robot.motor[joints] += robot.kp[joints] * (follow - target)
    robot.target[joints] = follow
