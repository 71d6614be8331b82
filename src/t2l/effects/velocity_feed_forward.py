"""A controller that damps the error's velocity, not only the joint's."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.sim.delay import DelayLine
from t2l.sim.loop import over_ticks


class VelocityFeedForward(Effect):
    """τ → τ + f Kd q̇_des, with the difference q̇_des of the last two commands."""

    name = "velocity_feed_forward"
    title = "velocity feed-forward"
    parameters = (
        Parameter("factor", "1", -1.0, 3.0, "of Kd q̇_des that is added, f", per_joint=False),
    )
    summary = "the controller adds a damping torque for the velocity of its commands"
    signature = "the joint lags behind a moving command less than Kd / Kp says"
    source = "LinuxCNC, HAL component pid: FF1, on the derivative of the command"
    acts_through = ("kp",)
    follows = "command velocity"
    order = -20

    def export(self, to, joints, values):
        to.call(self.name, add_command_velocity, joints, values, CONTROLLER)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)
        period = loop.schedule.command_period_s
        period = np.full(loop.nrec, loop.period_s) if period is None else period
        period = np.tile(period, loop.nvariant)[rows, None]
        # a command that is held for a period is the one before it a period ago
        before = DelayLine(period / loop.period_s)

        @over_ticks
        def change(tick, torque):
            command = loop.command[at]
            velocity = (command - before(command)) / period
            torque[at] += values["factor"] * loop.kd[at] * velocity

        loop.controller_filters.append(change)

    def starts(self, scales):
        return [{"factor": np.array([f])} for f in (0.1, 0.3, 0.5, 1.0)]


def add_command_velocity(robot, joints, values):
    """Add what the controller gives for the velocity of its commands."""
    state, target = robot.state, robot.target[joints]
    if not state:
        state.update(last=target, since=robot.tick, period=np.inf, velocity=np.zeros(len(joints)))
    ticks = robot.tick - state["since"]
    # commands come evenly: the shortest time between two that differ is their period
    if np.abs(target - state["last"]).max() > 1e-9:
        state["period"] = min(state["period"], ticks)
        state["velocity"] = (target - state["last"]) / (state["period"] * robot.period_s)
        state["last"], state["since"] = target, robot.tick
    elif ticks >= state["period"]:
        state["velocity"] = np.zeros(len(joints))
    robot.motor[joints] += values["factor"] * robot.kd[joints] * state["velocity"]
