"""When a plate is where it belongs."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.held_monitor import HeldMonitor

if TYPE_CHECKING:
    from t2l.tasks.dishrack import Dishrack


class PlateMonitor(HeldMonitor):
    """Success: the plate is placed, at rest, let go, for a fifth of a second.

    Failure kinds: `not_grasped` (it was never lifted), `not_released` (still in the hand), the
    task's own `missed` (let go at the goal, but not placed), `dropped` (elsewhere), `diverged`.
    """

    HOLD_S = 0.2
    REST_SPEED_M_S = 0.05
    LIFTED_M = 0.02
    # from the plate's middle to the tool: more than when it holds the rim
    LET_GO_M = 0.08
    AT_GOAL_M = 0.10

    def __init__(self, task: "Dishrack", nsim: int):
        super().__init__(nsim)
        self.task = task
        self._start_height = np.full(nsim, np.nan)
        self._lifted = np.zeros(nsim, dtype=bool)
        self._released = np.ones(nsim, dtype=bool)
        self._at_goal = np.zeros(nsim, dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        task = self.task
        position, rotation = task.plate_from_goal(batch)
        height, aside = position[:, 2], np.linalg.norm(position[:, :2], axis=1)
        speed = np.linalg.norm(batch.bind("qvel")[:, task.plate_dofs], axis=1)

        self._start_height = np.where(np.isnan(self._start_height), height, self._start_height)
        self._lifted[running] |= (height - self._start_height > self.LIFTED_M)[running]
        self._released[running] = (task.distance_from_grip(batch) > self.LET_GO_M)[running]
        self._at_goal[running] = (aside < self.AT_GOAL_M)[running]
        placed = (
            running
            & self._released
            & task.placed(position, rotation)
            & (speed < self.REST_SPEED_M_S)
        )
        self.held(placed, time_s)

    def failures(self, running: np.ndarray) -> list[str]:
        kinds = [
            ("not_grasped", ~self._lifted),
            ("not_released", ~self._released),
            (self.task.missed, self._at_goal),
        ]
        return self.named(running, kinds, "dropped")
