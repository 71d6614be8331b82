"""A motor that follows its torque command with a lag."""

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import each_tick, over_ticks


class ActuatorBandwidth(Effect):
    """τ̇ = ω (τ_command − τ)."""

    name = "actuator_bandwidth"
    title = "actuator bandwidth"
    parameters = (
        Parameter("cutoff", "Hz", 0.5, 500.0, "corner frequency", neutral=np.inf, log=True),
    )
    summary = "the motor torque follows its command with a first-order lag"
    signature = "the loop is less damped than its gains say: it overshoots and rings"
    source = "first-order lag, averaged exactly over each period of the loop"
    follows = "velocity"
    order = 30

    def export(self, to, joints, values):
        to.call(self.name, follow_with_a_lag, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        shares = shares_of_gap(values["cutoff"], loop.plant_period_s)
        state, at = {}, (rows, loop.columns(joints))

        @over_ticks
        def change(tick, torque):
            for now in each_tick(torque):
                now[at] = lagging(now[at].copy(), state, *shares)

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [{"cutoff": f * one} for f in (3.0, 10.0, 30.0, 100.0)]


def shares_of_gap(cutoff, period_s):
    """What is left of a gap to a held command after a period, and on average during it."""
    ticks = 2 * np.pi * cutoff * period_s
    return np.exp(-ticks), -np.expm1(-ticks) / ticks


def lagging(command, state, after, mean):
    """The mean torque of a period, N·m, behind a command; `state` keeps the torque at its end."""
    gap = state.get("torque", command) - command
    state["torque"] = command + gap * after
    return command + gap * mean


def follow_with_a_lag(robot, joints, values):
    """Let the motor torque follow its command with a first-order lag."""
    shares = shares_of_gap(values["cutoff"], robot.period_s)
    robot.motor[joints] = lagging(robot.motor[joints], robot.state, *shares)
