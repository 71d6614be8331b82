"""When a bar is handed over."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.task import Monitor

if TYPE_CHECKING:
    from t2l.tasks.bimanual_handover import BimanualHandover


class HandoverMonitor(Monitor):
    """Success: the second hand has held the bar above the table, alone, for half a second.

    Failure kinds, by how it is at the end: `not_grasped` (the bar never left the table), `dropped`
    (it did, and is back), `not_handed_over` (the first hand alone holds it), `not_released` (both
    are at it), `not_held` (the second alone, not for long enough), `diverged`.
    """

    HOLD_S = 0.5
    LIFTED_M = 0.02
    # of a tool from the bar's surface: farther than the fingers of an open hand
    REACH_M = 0.055

    def __init__(self, task: "BimanualHandover", nsim: int):
        self.task = task
        self.success_time_s = np.full(nsim, np.nan)
        self._held_since_s = np.full(nsim, np.nan)
        self._lifted = np.zeros(nsim, dtype=bool)
        self._on_table = np.ones(nsim, dtype=bool)
        self._at_bar = np.zeros((nsim, 2), dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        task = self.task
        off_table = task.height(batch) > self.LIFTED_M
        distance = [task.distance_from_bar(batch, arm) for arm in range(task.arms)]
        at_bar = np.stack(distance, axis=1) < task.bar_size_m[1:].max() / 2 + self.REACH_M
        self._lifted[running] |= off_table[running]
        self._on_table[running] = ~off_table[running]
        self._at_bar[running] = at_bar[running]

        held = running & off_table & ~at_bar[:, 0] & at_bar[:, 1]
        self._held_since_s[~held] = np.nan
        began = held & np.isnan(self._held_since_s)
        self._held_since_s[began] = time_s
        done = held & (time_s - self._held_since_s >= self.HOLD_S - 1e-9)
        self.success_time_s[done & np.isnan(self.success_time_s)] = time_s

    def failures(self, running: np.ndarray) -> list[str]:
        done = ~np.isnan(self.success_time_s)
        first, second = self._at_bar.T
        kinds = np.select(
            [done, ~running, ~self._lifted, self._on_table, first & second, first, second],
            [
                *("", "diverged", "not_grasped", "dropped"),
                *("not_released", "not_handed_over", "not_held"),
            ],
            "dropped",
        )
        return kinds.tolist()
