"""Commands in force over time, from points that a trajectory controller passes through.

Between points it moves in a straight line, or by a cubic where velocities are given, as ROS 2's
joint_trajectory_controller does. A new message replaces what is left of the one before.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np


@dataclass(frozen=True)
class Point:
    """To be at `position` (njoint,) rad at the time `at`, by a message in force from `since`, s."""

    since: float
    at: float
    position: np.ndarray
    velocity: np.ndarray | None


def held_commands(
    points: Sequence[Point], start: np.ndarray, rate_hz: float, until: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) s, increasing, and commands (n, njoint) rad, each held until the next.

    Args:
        points: by `since`, those of one message together and in their order; at least one.
        start: (njoint,) rad, from where the first message moves.
        rate_hz: at which motions between points are sampled.
        until: s, after which no command is asked for; the first one always is.
    """
    times: list[np.ndarray] = []
    commands: list[np.ndarray] = []
    messages = [list(own) for _, own in groupby(points, key=lambda point: point.since)]
    ends = [own[0].since for own in messages[1:]]
    position, velocity = np.asarray(start, float), None
    for own, end in zip(messages, [*ends, np.inf], strict=True):
        before, began = own[0].since, position
        for point in own:
            duration = point.at - before
            count = max(1, int(np.ceil(duration * rate_hz - 1e-6)))
            # a command is in force from the beginning of its period
            period = duration / count
            last = min(end, until if times else max(until, before + 1 / rate_hz))
            # no more than may be asked for, and one that rounding decides about
            most = 1 if period <= 0 else int(min(count, max(1.0, (last - before) / period + 2)))
            part = np.arange(1, most + 1) / count
            when = before + np.arange(most) * period
            kept = when < last
            times.append(when[kept])
            commands.append(_between(part[kept, None], duration, began, velocity, point))
            before, began, velocity = point.at, point.position, point.velocity
            if most < count or not kept.all():
                break
        position = next((block[-1] for block in reversed(commands) if len(block)), position)
        velocity = velocity if before <= end else None
    order, kept = np.unique(np.concatenate(times), return_index=True)
    return order, np.concatenate(commands)[kept]


def _between(part, duration, began, velocity, point: Point) -> np.ndarray:
    """(n, njoint) at parts (n, 1) of the motion to a point."""
    if point.velocity is None or velocity is None or duration <= 0:
        return began + part * (point.position - began)
    left = 1 - part
    return (
        (1 + 2 * part) * left**2 * began
        + part**2 * (1 + 2 * left) * point.position
        + duration * (part * left**2 * velocity - part**2 * left * point.velocity)
    )
