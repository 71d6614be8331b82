"""A set-point that follows the command no faster than a profile allows."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.sim.loop import each_tick, over_ticks


class SetPointProfile(Effect):
    """|ẋ| ≤ v, |ẍ| ≤ a, and the set-point x comes to rest at the command without passing it."""

    name = "set_point_profile"
    title = "motion profile"
    parameters = (
        Parameter(
            "velocity", "rad/s", 0.02, 1e3, "of the set-point, v", neutral=np.inf, log=True,
            scale="velocity",
        ),
        Parameter(
            "acceleration", "rad/s²", 0.1, 1e6, "of the set-point, a", neutral=np.inf, log=True,
            scale="velocity",
        ),
    )  # fmt: skip
    summary = "the servo moves its set-point to the command within a velocity and an acceleration"
    signature = "the joint follows slow commands and falls behind fast ones, alike at all gains"
    source = "ROBOTIS, XM430-W350 e-Manual: Profile Velocity, Profile Acceleration, trapezoidal"
    acts_through = ("kp",)
    follows = "command velocity"
    order = 6

    def export(self, to, joints, values):
        to.call(self.name, profile_commands, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        state, at = {}, (rows, loop.columns(joints))
        velocity, acceleration = values["velocity"], values["acceleration"]

        @over_ticks
        def change(tick, target):
            limits = velocity, acceleration, loop.real_period_s
            for now in each_tick(target):
                # a tick may hold several of the real loop, of which the torque sees the mean
                command = now[at].copy()
                steps = [profiled(command, state, *limits) for _ in range(loop.schedule.coarseness)]
                now[at] = sum(steps) / len(steps)

        loop.command_filters.append(change)

    def starts(self, scales):
        speed = scales.velocity
        return [
            {"velocity": v * speed, "acceleration": a * speed}
            for v, a in ((4.0, 400.0), (2.0, 200.0), (2.0, 40.0), (1.0, 100.0), (1.0, 20.0))
        ]


def profiled(command, state, velocity, acceleration, period_s):
    """The set-point, rad, a tick nearer to a command; `state` keeps it and its velocity."""
    x, v = state.get("x", command), state.get("v", 0.0 * command)
    way = command - x
    size = np.abs(way)
    # from this speed, held for a tick, the acceleration just stops in time
    stops = 2 * size / (period_s + np.sqrt(period_s**2 + 2 * size / acceleration))
    wanted = np.sign(way) * np.minimum(stops, velocity)
    change = acceleration * period_s
    v = v + np.minimum(np.maximum(wanted - v, -change), change)
    state["x"], state["v"] = x + v * period_s, v
    return state["x"]


def profile_commands(robot, joints, values):
    """Let the controller follow a set-point that moves within its profile."""
    target, limits = robot.target[joints], (values["velocity"], values["acceleration"])
    follow = profiled(target.copy(), robot.state, *limits, robot.period_s)
    robot.motor[joints] += robot.kp[joints] * (follow - target)
    robot.target[joints] = follow
