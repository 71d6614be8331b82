"""A controller that damps by a velocity it has smoothed."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.sim.loop import each_tick, over_ticks


class VelocityFilter(Effect):
    """ẋ = ω (q̇ − x), and the controller's damping is −Kd x."""

    name = "velocity_filter"
    title = "velocity low-pass"
    parameters = (
        Parameter(
            "cutoff", "Hz", 0.5, 500.0, "corner frequency", neutral=np.inf, log=True,
            per_joint=False,
        ),
    )  # fmt: skip
    summary = "the controller smooths the velocity that it measures before it damps by it"
    signature = "fast motion is less damped than the gains say, most where Kd is large"
    source = "first-order low-pass, exact for a held velocity"
    acts_through = ("kd",)
    follows = "acceleration"
    order = -5

    def export(self, to, joints, values):
        to.call(self.name, damp_by_smooth_velocity, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        keep = np.exp(-2 * np.pi * values["cutoff"] * loop.period_s)
        state, at = {}, (rows, loop.columns(joints))

        @over_ticks
        def change(tick, torque):
            both = zip(each_tick(torque), each_tick(loop.measured_dq), strict=True)
            for now, speed in both:
                now[at] += loop.kd[at] * (speed[at] - smoothed(speed[at], state, keep))

        loop.controller_filters.append(change)

    def starts(self, scales):
        return [{"cutoff": np.array([f])} for f in (3.0, 10.0, 30.0, 100.0)]


def smoothed(velocity, state, keep):
    """The filter's output, rad/s, which `state` keeps."""
    smooth = velocity + (state.get("smooth", velocity) - velocity) * keep
    state["smooth"] = smooth
    return smooth


def damp_by_smooth_velocity(robot, joints, values):
    """Let the controller damp by a velocity that it has smoothed."""
    velocity = robot.dq[joints]
    keep = np.exp(-2 * np.pi * values["cutoff"] * robot.period_s)
    smooth = smoothed(velocity, robot.state, keep)
    robot.motor[joints] += robot.kd[joints] * (velocity - smooth)
