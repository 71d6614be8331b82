"""A controller that integrates its position error too."""

import numpy as np

from t2l.effects.effect import AT_REST_RAD_S, Effect, Parameter
from t2l.effects.exported import CONTROLLER
from t2l.sim.loop import each_tick, over_ticks

SLOPE, TINY = 1e-6, 1e-12  # numerics: share of a torque and N·m, of a difference; a slope of zero
HELD_RAD = 0.15  # bound: position error whose torque an integral may begin with
SECANTS = 2  # numerics: steps to a demand; one is exact where motors give a share of it


class IntegralAction(Effect):
    """τ_I(k) = clip(τ_I(k−1) + Ki h (q_des − q), ±limit): anti-windup by clamping.

    It begins with the torque that holds the joint where it starts, whatever else acts on it, give
    or take what friction holds; in motion nobody knows it.
    """

    name = "integral_action"
    title = "integral action"
    parameters = (
        Parameter(
            "gain", "N·m/(rad·s)", 0.0, 100.0, "torque by integrated position error, Ki", scale="kp"
        ),
        Parameter(
            "limit", "N·m", 1e-3, 1e3, "where the integral's torque is clamped", neutral=np.inf,
            log=True, scale="torque",
        ),
    )  # fmt: skip
    summary = "the controller has an I beside its P and D, clamped so that it does not wind up"
    signature = "a constant load leaves no lasting error, and the response overshoots slowly"
    source = "Åström and Hägglund, Advanced PID control, 2006, section 3.5: clamped integrator"
    acts_through = ("kp",)
    follows = "constant"
    holds_torque = holds_at_rest = True
    order = -10  # the loop's rate and all else act on the whole torque

    def export(self, to, joints, values):
        to.call(self.name, integrate_error, joints, values, CONTROLLER)

    def held(self, values):
        limit = values["limit"]
        return limit, np.full_like(limit, np.inf)

    def install(self, loop, rows, joints, values):
        at, period, state = (rows, loop.columns(joints)), loop.period_s, {}
        gain, limit = values["gain"], values["limit"]
        # the mean over a tick of the sums at each of the real ticks in it
        first = 0.5 * (period + loop.real_period_s)
        passive, bias = loop.batch.bind("qfrc_passive"), loop.batch.bind("qfrc_bias")

        @over_ticks
        def change(tick, torque):
            signals = loop.command, loop.measured, loop.measured_dq, torque
            for command, measured, dq, now in zip(*map(each_tick, signals), strict=True):
                error = command[at] - measured[at]
                if not state:
                    pulled = loop.kp[at] * error
                    known, added = loop.taken is not None, gain * first * error
                    load = loop.taken if known else (bias - passive)[:, loop.dofs]
                    load, held = demand_at_rest(loop, load), np.abs(dq[at]) < AT_REST_RAD_S
                    begun = first_sum(load[at], now[at], pulled, held | known, gain, added)
                    friction = loop.friction_at_rest(bias[:, loop.dofs])[at]
                    most = np.where(loop.moving[rows], HELD_RAD * loop.kp[at], friction)
                    most = np.where(gain > 0, most, 0.0)
                    most = np.minimum(most, limit)
                    state["sum"] = loop.held_at_start(rows, joints, begun, most, limit)
                now[at] += integrated(state, gain * error, first, period, limit)

        loop.controller_filters.append(change)

    def starts(self, scales):
        return [
            {"gain": scales.kp / time_s, "limit": share * scales.torque}
            for time_s in (60.0, 15.0, 4.0, 1.5, 0.4)  # of the stiffest recording
            for share in (0.01, 0.1, 0.5, 10.0)
        ]


def demand_at_rest(loop, load):
    """N·m that a controller asks for where joints rest: what remembers has no part in it.

    Args:
        loop: or an exported robot.
        load: N·m that the weight takes, less springs of the model.
    """
    needed = load - loop.torques_at_rest()
    demand, step = needed.copy(), SLOPE * np.abs(needed) + TINY
    for _ in range(SECANTS):
        given = loop.given_at_rest(demand)
        slope = (loop.given_at_rest(demand + step) - given) / step
        # a motor at its limit gives no more
        gives = slope > SLOPE
        demand += np.where(gives, needed - given, 0.0) / np.where(gives, slope, 1.0)
    return demand


def first_sum(load, given, pulled, held, gain, added):
    """N·m with which the integral begins.

    Args:
        load: N·m that a controller asks for to hold the joint, or to move it as it does.
        given: N·m that the controller gives without it, of which `pulled` are Kp (q_des − q).
        held: whether it is one of these.
        added: N·m that it adds at once.
    """
    given = np.where(held, given, given - pulled)
    return np.where(gain > 0, load - given, 0.0) - held * added


def integrated(state, rate, first_s, period_s, limit):
    """The integral's torque in a period, N·m, at a rate in N·m/s; `state` keeps its end."""
    torque = clamped(state["sum"] + rate * first_s, limit)
    state["sum"] = clamped(state["sum"] + rate * period_s, limit)
    return torque


def clamped(values, limit):
    """Values within ± limit."""
    return np.minimum(np.maximum(values, -limit), limit)


def integrate_error(robot, joints, values):
    """Add the torque of the integrated position error."""
    gain, period_s, motor = values["gain"], robot.period_s, robot.motor[joints]
    error = robot.target[joints] - robot.q[joints]
    if not robot.state:
        load = demand_at_rest(robot, robot.load - robot.passive)[joints]
        held = np.abs(robot.dq[joints]) < AT_REST_RAD_S
        robot.state["sum"] = first_sum(
            load, motor, robot.kp[joints] * error, held, gain, gain * period_s * error
        )
    added = integrated(robot.state, gain * error, period_s, period_s, values["limit"])
    robot.motor[joints] = motor + added
