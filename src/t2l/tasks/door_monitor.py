"""When a door is open."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.held_monitor import HeldMonitor

if TYPE_CHECKING:
    from t2l.tasks.dishwasher import Dishwasher


class DoorMonitor(HeldMonitor):
    """Success: the door is open.

    Failure kinds: `not_moved` (the door never left its frame), `slipped` (it did, and the hand is
    off the bar at the end), `not_opened` (the hand still holds it), `diverged`.
    """

    MOVED_RAD = 0.05
    HELD_M = 0.04  # from the tool to the bar's line, more than a grasp leaves

    def __init__(self, task: "Dishwasher", nsim: int):
        super().__init__(nsim)
        self.task = task
        self._moved = np.zeros(nsim, dtype=bool)
        self._held = np.zeros(nsim, dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        angle = self.task.door_angle(batch)
        self._moved[running] |= angle[running] > self.MOVED_RAD
        self._held[running] = (self.task.distance_from_bar(batch) < self.HELD_M)[running]
        self.held(running & (angle >= self.task.opened_rad), time_s)

    def failures(self, running: np.ndarray) -> list[str]:
        kinds = [
            ("not_moved", ~self._moved),
            ("slipped", ~self._held),
        ]
        return self.named(running, kinds, "not_opened")
