"""Commands in force over time, from points that a trajectory controller passes through.

Between points it moves in a straight line, or by a cubic where velocities are given, as ROS 2's
joint_trajectory_controller does. A new message replaces what is left of the one before.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Point:
    """To be at `position` (njoint,) rad at the time `at`, by a message in force from `since`, s."""

    since: float
    at: float
    position: np.ndarray
    velocity: np.ndarray | None


def held_commands(
    points: Sequence[Point], start: np.ndarray, rate_hz: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) s, increasing, and commands (n, njoint) rad, each held until the next.

    Args:
        points: by `since`, those of one message together and in their order.
        start: (njoint,) rad, from where the first message moves.
        rate_hz: at which motions between points are sampled.
    """
    times: list[float] = []
    commands: list[np.ndarray] = []
    starts = sorted({point.since for point in points})
    ends = dict(zip(starts, [*starts[1:], np.inf], strict=True))
    position, velocity = np.asarray(start, float), None
    for since in starts:
        before, began = since, position
        for point in (p for p in points if p.since == since):
            duration = point.at - before
            steps = np.arange(1, max(1, int(np.ceil(duration * rate_hz - 1e-6))) + 1)
            share = steps / steps[-1]
            for part in share:
                now = before + part * duration
                # a command is in force from the beginning of its period
                when = now - duration / len(share)
                if when >= ends[since]:
                    break
                times.append(when)
                commands.append(_between(part, duration, began, velocity, point))
            before, began, velocity = point.at, point.position, point.velocity
        position = commands[-1] if commands else position
        velocity = velocity if before <= ends[since] else None
    order, kept = np.unique(np.array(times), return_index=True)
    return order, np.array(commands)[kept]


def _between(part, duration, began, velocity, point: Point) -> np.ndarray:
    if point.velocity is None or velocity is None or duration <= 0:
        return began + part * (point.position - began)
    left = 1 - part
    return (
        (1 + 2 * part) * left**2 * began
        + part**2 * (1 + 2 * left) * point.position
        + duration * (part * left**2 * velocity - part**2 * left * point.velocity)
    )
