"""A motor whose torque the supply voltage and its own speed limit."""

from collections.abc import Callable

import numpy as np

from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.servo import ServoLoop

SHORT = 0.8  # numerics: of what is asked for, less than which a motor at its limit gives
LARGE = 0.2  # numerics: of the largest torque, below which friction may be what is short
FEWEST = 8  # numerics: samples of a motor at its limit
FAR = 5.0  # numerics: times what is asked for, where no limit is seen
TINY = 1e-9  # numerics: above zero
FLATTEST = 0.05  # numerics: of the stall torque, what the fastest motion costs at least
RATED_V = 12.0  # format: of the parameters, and of a log without `supply_voltage`


class TorqueSpeedLimit(Effect):
    """−τs u − τs q̇/ω0 ≤ τ ≤ τs u − τs q̇/ω0, with u the supply voltage over 12 V.

    What is left of the voltage after the back-EMF drives a current through the winding.
    """

    name = "torque_speed_limit"
    title = "torque-speed limit"
    parameters = (
        Parameter(
            "stall_torque", "N·m", 1e-3, 1e3, "at rest and 12 V, τs", neutral=np.inf, log=True,
            scale="peak_torque",
        ),
        Parameter(
            "no_load_speed", "rad/s", 0.05, 1e4, "without torque at 12 V, ω0", neutral=np.inf,
            log=True, scale="velocity",
        ),
    )  # fmt: skip
    summary = "the faster the motor turns, the less torque its supply voltage can give"
    signature = "the error appears where the commanded torque is large and the joint is fast"
    source = "MuJoCo, DC motor technical note: τ = k_t (V − k_e ω) / R at full voltage"
    remembers = False
    follows = "velocity"
    reads = ("motor", "velocity")
    order = 20

    def export(self, to, joints, values):
        to.call(self.name, less_torque_at_speed, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        stall, slope = values["stall_torque"], values["stall_torque"] / values["no_load_speed"]
        at = ..., rows, loop.columns(joints)

        def most(tick, dq):
            volts = loop.logged("supply_voltage", tick)
            return (stall if volts is None else stall * volts[at] / RATED_V) - slope * dq

        limit_by_velocity(loop, rows, joints, most)

    def starts(self, scales):
        return [
            {"stall_torque": t * scales.peak_torque, "no_load_speed": s * scales.velocity}
            for t, s in (
                (0.3, 5.0), (0.3, 15.0), (0.7, 2.0), (0.7, 5.0), (1.2, 2.0), (2.0, 2.0), (0.3, 2.0),
            )
        ]  # fmt: skip

    def read_off(self, q, torque, clock_s, motor, velocity):
        way, asked, fastest = np.sign(motor), np.abs(motor), np.abs(velocity).max()
        given = way * (motor + torque)
        limited = (given < SHORT * asked) & (given > 0) & (asked > LARGE * asked.max())
        if limited.sum() < FEWEST or not fastest:
            torque, speed = FAR * max(asked.max(), TINY), FAR * max(fastest, TINY)
            return {"stall_torque": torque, "no_load_speed": speed}
        slope, stall = np.polyfit(way[limited] * velocity[limited], given[limited], 1)
        stall = max(stall, np.median(given[limited]))
        cost = max(-slope, FLATTEST * stall / fastest)
        return {"stall_torque": stall, "no_load_speed": stall / cost}


def limit_by_velocity(loop: ServoLoop, rows: slice, joints: np.ndarray, most: Callable) -> None:
    """Limit the motor torque of joints by their velocity, either way alike.

    Args:
        most: called with (tick, velocity), both (nrow, njoint): the greatest torque there.
    """

    def limited(tick, torque, dq):
        return np.minimum(np.maximum(torque, -most(tick, -dq)), most(tick, dq))

    loop.motor_filters.append(loop.in_motion(rows, joints, limited))


def less_torque_at_speed(robot, joints, values):
    """Cut what the motor cannot give at its speed and 12 V."""
    stall = values["stall_torque"]
    induced = stall / values["no_load_speed"] * robot.dq[joints]
    robot.motor[joints] = np.clip(robot.motor[joints], -stall - induced, stall - induced)
