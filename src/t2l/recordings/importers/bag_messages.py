"""Messages of a bag in the order of their stamps; whatever is left out of them is said."""

import logging
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from t2l.errors import RecordingError

logger = logging.getLogger(__name__)

TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
NANO = 1e-9  # format: a nanosecond in s

# bound: no message overtakes others by more; a clock that NTP sets steps by 0.128 s or more
MOST_LATE_S = 0.1
# bound: of what a clock runs ahead of another between two messages, if neither was set
MOST_AHEAD_S = 10.0


@dataclass(frozen=True)
class Received:
    """A message; `stamp` and `received` are ns by the sender's clock and the receiver's."""

    stamp: int
    received: int
    kind: str
    message: Any


def accepted(bag: Path, topic: str, commands: list[Received]) -> list[Received]:
    """Those that a controller acts on: a trajectory needs points, one after the other.

    Raises:
        RecordingError: there is none.
    """

    def fine(one: Received) -> bool:
        if one.kind != TRAJECTORY:
            return True
        times = [
            point.time_from_start.sec * 10**9 + point.time_from_start.nanosec  # format: ns
            for point in one.message.points
        ]
        return bool(times) and all(a < b for a, b in pairwise([-1, *times]))

    kept = [one for one in commands if fine(one)]
    if not kept:
        raise RecordingError(
            bag, f"topic {topic}", f"{len(commands)} trajectories without points in turn",
            "at least one with a point, and with times that rise from point to point",
        )  # fmt: skip
    why = "without points, or with points whose times do not rise: no controller takes them"
    say(bag, topic, len(commands) - len(kept), len(commands), why)
    return kept


def in_order(bag: Path, topic: str, found: list[Received]) -> list[Received]:
    """In the order of their stamps, of those with one stamp the last.

    Raises:
        RecordingError: the clock of the stamps was set back in between.
    """
    newest = found[0]
    for number, (before, one) in enumerate(pairwise(found), start=2):
        back = (newest.stamp - one.stamp) * NANO
        if back > MOST_LATE_S:
            raise RecordingError(
                bag, f"topic {topic}, message {number}",
                f"a stamp {back:.4g} s before that of an earlier message: a clock was set back",
                f"stamps that rise, but for {MOST_LATE_S:g} s; try clock: received, or cut the bag",
            )  # fmt: skip
        ahead = (one.stamp - before.stamp - (one.received - before.received)) * NANO
        if ahead > MOST_AHEAD_S:
            logger.warning(
                "%s: topic %s: the stamp of message %d is %.4g s ahead of that before, though "
                "%.4g s lie between their receptions: a clock may have been set; the command is "
                "held in between",
                bag, topic, number, (one.stamp - before.stamp) * NANO,
                (one.received - before.received) * NANO,
            )  # fmt: skip
        newest = max(newest, one, key=lambda each: each.stamp)
    latest = {one.stamp: one for one in found}
    say(bag, topic, len(found) - len(latest), len(found), "as the next has the same stamp")
    return [latest[stamp] for stamp in sorted(latest)]


def say(bag: Path, topic: str, count: int, total: int, why: str) -> None:
    """Tell how many messages are left out, if any, and why."""
    if count:
        logger.warning(
            "%s: topic %s: %d of %d messages left out, %s", bag, topic, count, total, why
        )
