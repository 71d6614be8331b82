"""When a door is open."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.task import Monitor

if TYPE_CHECKING:
    from t2l.tasks.dishwasher import Dishwasher


class DoorMonitor(Monitor):
    """Success: the door is open.

    Failure kinds: `not_moved` (the door never left its frame), `slipped` (it did, and the hand is
    off the bar at the end), `not_opened` (the hand still holds it), `diverged`.
    """

    MOVED_RAD = 0.05
    HELD_M = 0.04  # from the tool to the bar's line, more than a grasp leaves

    def __init__(self, task: "Dishwasher", nsim: int):
        self.task = task
        self.success_time_s = np.full(nsim, np.nan)
        self._moved = np.zeros(nsim, dtype=bool)
        self._held = np.zeros(nsim, dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        angle = self.task.door_angle(batch)
        self._moved[running] |= angle[running] > self.MOVED_RAD
        self._held[running] = (self.task.distance_from_bar(batch) < self.HELD_M)[running]
        opened = running & (angle >= self.task.opened_rad) & np.isnan(self.success_time_s)
        self.success_time_s[opened] = time_s

    def failures(self, running: np.ndarray) -> list[str]:
        done = ~np.isnan(self.success_time_s)
        kinds = np.select(
            [done, ~running, ~self._moved, ~self._held],
            ["", "diverged", "not_moved", "slipped"],
            "not_opened",
        )
        return kinds.tolist()
