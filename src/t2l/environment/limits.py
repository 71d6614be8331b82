"""What a deployed policy must not do: leave the robot's limits, or jitter where it should rest."""

from typing import NamedTuple

import numpy as np

from t2l.robots import Robot
from t2l.sim.arrays import Array, like, namespace

LIMITS = ("position", "velocity", "torque", "torque_rate")
# what is told of an episode: a limit exceeded at some instant, or jitter at its end
NAMES = (*LIMITS, "jitter")

# the study's, section IV-D: standard deviation of a joint's velocity over the last seconds
JITTER_RAD_S = 0.04
JITTER_WINDOW_S = 2.0

# a joint whose home is at an end of its range, such as a finger, rests against a stop, which gives
# way in a simulation: that far about home no position is a violation
AT_REST_RAD = 1e-3


class Limits(NamedTuple):
    """What a robot must keep to, (njoint,) each.

    Attributes:
        lowest, highest: position, rad; what a robot has at rest at home is within them.
        velocity, torque: rad/s and N·m, either way.
        torque_change: N·m from one instant to the next, either way.
    """

    lowest: Array
    highest: Array
    velocity: Array
    torque: Array
    torque_change: Array

    @classmethod
    def of(cls, robot: Robot, period_s: float) -> "Limits":
        """A robot's, looked at every `period_s`."""
        low, high = robot.position_limit.T
        return cls(
            np.minimum(low, robot.home - AT_REST_RAD), np.maximum(high, robot.home + AT_REST_RAD),
            robot.velocity_limit, robot.torque_limit, robot.torque_rate_limit * period_s,
        )  # fmt: skip

    def like(self, array: Array) -> "Limits":
        """The same where `array` is: what is compared at every instant is to be there already."""
        return Limits(*(like(limit, array) for limit in self))


def violations(q: Array, dq: Array, torque: Array, torque_before: Array, limits: Limits) -> Array:
    """Which limits a robot exceeds at an instant, on any joint: (n, 4) bool in order of `LIMITS`.

    Args:
        q, dq: (n, njoint), rad and rad/s.
        torque, torque_before: (n, njoint) N·m that the controller asks for, before any clamp, now
            and an instant earlier.
    """
    xp = namespace(q)
    exceeded = (
        (q < limits.lowest) | (q > limits.highest),
        xp.abs(dq) > limits.velocity,
        xp.abs(torque) > limits.torque,
        xp.abs(torque - torque_before) > limits.torque_change,
    )
    return xp.any(xp.stack(exceeded, axis=1), axis=2)


def jitter(dq: np.ndarray, rate_hz: float) -> np.ndarray:
    """Largest standard deviation of a joint's velocity over the last `JITTER_WINDOW_S`: (n,) rad/s.

    Args:
        dq: (nsample, n, njoint) rad/s at `rate_hz`, whole rollouts; a shorter one counts whole.
    """
    window = dq[-round(JITTER_WINDOW_S * rate_hz) :]
    return window.std(axis=0).max(axis=1)
