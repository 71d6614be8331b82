"""Waypoints of a grip frame and the smooth motion through them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.spatial.transform import Rotation

from t2l.robots.minimum_jerk import minimum_jerk

POINTING_DOWN = Rotation.from_matrix([[1, 0, 0], [0, -1, 0], [0, 0, -1]])


@dataclass(frozen=True)
class Waypoint:
    """Where the grip frame is to be, at rest, `duration_s` after the waypoint before.

    Attributes:
        position: (3,) m, world.
        rotation: world orientation of the grip frame.
        gripper: finger command in m while moving there.
    """

    position: np.ndarray
    rotation: Rotation
    duration_s: float
    gripper: float


@dataclass(frozen=True)
class Arc(Waypoint):
    """A waypoint that is reached on a circle.

    Attributes:
        pivot: (3,) m, a point of the axis.
        turn: (3,) rad, by how much the position turns about the axis.
    """

    pivot: np.ndarray
    turn: np.ndarray

    @classmethod
    def after(
        cls,
        before: Waypoint,
        rotation: Rotation,
        duration_s: float,
        pivot: np.ndarray,
        turn: np.ndarray,
    ) -> Self:
        """From where `before` ends, its gripper command kept."""
        end = pivot + Rotation.from_rotvec(turn).apply(before.position - pivot)
        return cls(end, rotation, duration_s, before.gripper, pivot, turn)


# of a tool: position, rotation and gripper command, as of a waypoint
Goal = tuple[np.ndarray, Rotation, float]


def in_step(phases: Sequence[tuple[float, Sequence[Goal | None]]]) -> list[list[Waypoint]]:
    """Waypoints of several tools that wait for one another: a phase ends for all at once.

    Args:
        phases: how long each takes, s, and where each tool is at its end; None stays where it is,
            from the second phase on.
    """
    tools: list[list[Waypoint]] = [[] for _ in phases[0][1]]
    for duration, goals in phases:
        for waypoints, goal in zip(tools, goals, strict=True):
            if goal is None:
                waypoints.append(replace(waypoints[-1], duration_s=duration))
            else:
                position, rotation, gripper = goal
                waypoints.append(Waypoint(position, rotation, duration, gripper))
    return tools


@dataclass(frozen=True)
class Motion:
    """A sampled motion of n steps.

    Attributes:
        position: (n, 3) m; rotation: (n, 3, 3).
        twist: (n, 6) m/s above rad/s; acceleration: (n, 6) m/s² above rad/s².
        gripper: (n,) m.
        arrived: (n,) bool, whether it is at a waypoint.
    """

    position: np.ndarray
    rotation: np.ndarray
    twist: np.ndarray
    acceleration: np.ndarray
    gripper: np.ndarray
    arrived: np.ndarray


def motion_through(start: Waypoint, waypoints: Sequence[Waypoint], timestep_s: float) -> Motion:
    """Minimum-jerk motion from `start` through every waypoint, resting at each."""
    segments = []
    for a, b in zip([start, *waypoints], waypoints, strict=False):
        steps = max(1, round(b.duration_s / timestep_s))
        duration = steps * timestep_s
        path, speed, acceleration = (
            column[:, None] for column in minimum_jerk(np.arange(1, steps + 1) / steps)
        )
        # a turn about one fixed axis, so its rates are those of the path times the axis
        turn = (b.rotation * a.rotation.inv()).as_rotvec()
        rates = path, speed / duration, acceleration / duration**2
        position, velocity, its_change = _travel(a, b, *rates)
        segments.append(
            Motion(
                position=position,
                rotation=(Rotation.from_rotvec(path * turn) * a.rotation).as_matrix(),
                twist=np.concatenate([velocity, rates[1] * turn], axis=1),
                acceleration=np.concatenate([its_change, rates[2] * turn], axis=1),
                gripper=np.full(steps, b.gripper),
                arrived=np.arange(1, steps + 1) == steps,
            )
        )
    fields = Motion.__dataclass_fields__
    return Motion(**{f: np.concatenate([getattr(s, f) for s in segments]) for f in fields})


def _travel(
    a: Waypoint, b: Waypoint, path: np.ndarray, speed: np.ndarray, acceleration: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration (n, 3) on the way from `a` to `b`.

    Args:
        path, speed, acceleration: (n, 1) of the way, which is 1: 1, 1/s and 1/s².
    """
    if not isinstance(b, Arc):
        offset = b.position - a.position
        return a.position + path * offset, speed * offset, acceleration * offset
    arm = Rotation.from_rotvec(path * b.turn).apply(a.position - b.pivot)
    velocity = np.cross(speed * b.turn, arm)
    change = np.cross(acceleration * b.turn, arm) + np.cross(speed * b.turn, velocity)
    return b.pivot + arm, velocity, change


def padded(motion: Motion, steps: int) -> Motion:
    """The motion followed by rest at its end, `steps` long."""
    rest = steps - len(motion.gripper)
    moving = {"twist", "acceleration"}

    def pad(field: str) -> np.ndarray:
        values = getattr(motion, field)
        end = np.zeros_like(values[-1:]) if field in moving else values[-1:]
        return np.concatenate([values, np.repeat(end, rest, axis=0)])

    return Motion(**{field: pad(field) for field in Motion.__dataclass_fields__})
