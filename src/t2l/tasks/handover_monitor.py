"""When a bar is handed over."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.held_monitor import HeldMonitor

if TYPE_CHECKING:
    from t2l.tasks.bimanual_handover import BimanualHandover


class HandoverMonitor(HeldMonitor):
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
        super().__init__(nsim)
        self.task = task
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
        self.held(held, time_s)

    def failures(self, running: np.ndarray) -> list[str]:
        first, second = self._at_bar.T
        kinds = [
            ("not_grasped", ~self._lifted),
            ("dropped", self._on_table),
            ("not_released", first & second),
            ("not_handed_over", first),
            ("not_held", second),
        ]
        return self.named(running, kinds, "dropped")
