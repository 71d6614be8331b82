"""What a deployed policy must not do: rates at which it leaves the robot's limits."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from t2l.robots import Robot

NAMES = ("position", "velocity", "torque", "torque_rate")

# largest tolerated share of instants, the study's
TOLERATED = {"position": 0.0, "velocity": 0.0, "torque": 0.0, "torque_rate": 0.2}


def violations(
    q: np.ndarray,
    dq: np.ndarray,
    torque: np.ndarray,
    torque_before: np.ndarray,
    period_s: float,
    robot: Robot,
) -> np.ndarray:
    """Which limits a robot exceeds at an instant, on any joint: (n, 4) bool in order of `NAMES`.

    Args:
        q, dq: (n, njoint), rad and rad/s.
        torque, torque_before: (n, njoint) N·m that the controller asks for, before any clamp, now
            and a period earlier.
        robot: whose limits they are.
    """
    exceeded = np.empty((len(q), len(NAMES), q.shape[1]), bool)
    low, high = robot.position_limit.T
    np.logical_or(q < low, q > high, out=exceeded[:, 0])
    np.greater(np.abs(dq), robot.velocity_limit, out=exceeded[:, 1])
    np.greater(np.abs(torque), robot.torque_limit, out=exceeded[:, 2])
    change = np.abs(torque - torque_before)
    np.greater(change, robot.torque_rate_limit * period_s, out=exceeded[:, 3])
    return exceeded.any(axis=2)


@dataclass(frozen=True)
class Evaluation:
    """Success rate over episodes, and the share of instants that violated each constraint."""

    success: float
    rates: Mapping[str, float]

    @property
    def objective(self) -> float:
        """The study's two-stage objective of a trial, 0 to 2.

        1 + success where every rate is tolerated, else success · Π max(0, 1 − (v_c − v̄_c)) over
        the constraints c that are not.
        """
        excess = [self.rates[name] - TOLERATED[name] for name in NAMES]
        if all(value <= 0 for value in excess):
            return 1.0 + self.success
        return self.success * math.prod(max(0.0, 1.0 - max(0.0, value)) for value in excess)
