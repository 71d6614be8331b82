"""Gears that pass on more of the motor's torque at one angle than at the next."""

import numpy as np

from t2l.effects.cogging import FEWEST, MOST, strongest_ripple
from t2l.effects.effect import Effect, Parameter
from t2l.effects.exported import MOTOR
from t2l.sim.loop import over_ticks

LARGEST = 0.9  # bound: of a first guess: the motor does not change its direction


class TorqueRippleWithPosition(Effect):
    """τ_motor → τ_motor (1 + a sin(N q + φ))."""

    name = "torque_ripple_with_position"
    title = "gear wobble"
    parameters = (
        Parameter("amplitude", "1", 0.0, 0.9, "largest part of the motor torque, a"),
        Parameter(
            "phase", "rad", -30.0, 30.0, "angle of the ripple where q is zero, φ", neutral=np.nan
        ),
        Parameter(
            "periods", "1/rev", FEWEST, MOST, "periods in a turn of the joint, N", neutral=np.nan
        ),
    )
    summary = "the part of the motor torque that gears pass on ripples with the joint angle"
    signature = "the error repeats over the position and grows with the commanded torque"
    source = (
        "Ghorbel, Gandhi and Alpeter, On the kinematic error in harmonic drive gears, 2001: the "
        "ratio, thus the torque passed on, is periodic in the angle"
    )
    remembers = False
    follows = "position"
    reads = ("motor",)
    order = 45

    def export(self, to, joints, values):
        to.call(self.name, wobble, joints, values, MOTOR)

    def install(self, loop, rows, joints, values):
        at = ..., rows, loop.columns(joints)

        @over_ticks
        def change(tick, torque):
            # the angle in the middle of the period for which the torque is held
            q = loop.q[at] + 0.5 * loop.plant_period_s * loop.dq[at]
            ripple = np.sin(values["periods"] * q + values["phase"])
            torque[at] *= 1 + values["amplitude"] * ripple

        loop.motor_filters.append(change)

    def starts(self, scales):
        one = np.ones_like(scales.torque)
        return [
            {"amplitude": 0.1 * one, "phase": 0.0 * one, "periods": n * one}
            for n in (4.0, 10.0, 30.0, 100.0)
        ]

    def read_off(self, q, torque, clock_s, motor=None):
        if motor is None:
            return None
        periods, (sine, cosine) = strongest_ripple(q, torque, motor)
        return {
            "amplitude": min(np.hypot(sine, cosine), LARGEST),
            "phase": np.arctan2(cosine, sine),
            "periods": periods,
        }


def wobble(robot, joints, values):
    """Let gears pass on a part of the motor torque that ripples with the angle."""
    ripple = np.sin(values["periods"] * robot.angle[joints] + values["phase"])
    robot.motor[joints] *= 1 + values["amplitude"] * ripple
