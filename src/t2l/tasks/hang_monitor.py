"""When a mug hangs."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.held_monitor import HeldMonitor
from t2l.tasks.mug import HEIGHT

if TYPE_CHECKING:
    from t2l.tasks.mug_hanging import MugHanging


class HangMonitor(HeldMonitor):
    """Success: the hand has left the mug, and half a second later the handle is still on the peg.

    Failure kinds: `not_grasped` (the mug never left the table), `not_released` (at the end it is
    in the hand, or not yet let go for so long), `missed` (it was at the peg and is not on it),
    `dropped` (it never came there), `diverged`.
    """

    HOLD_S = 0.5
    LIFTED_M = 0.02
    AT_TIP_M = 0.06  # from the handle to the tip of the peg: half a length before it
    MARGIN_M = 0.01  # between the fingertips and a mug that is let go

    def __init__(self, task: "MugHanging", nsim: int):
        super().__init__(nsim)
        self.task = task
        self._lifted = np.zeros(nsim, dtype=bool)
        self._at_peg = np.zeros(nsim, dtype=bool)
        self._unfinished = np.zeros(nsim, dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        task = self.task
        middle = task.mug_pose(batch)[:, :3]
        above_table = middle[:, 2] > HEIGHT / 2 + self.LIFTED_M
        away = np.linalg.norm(middle - task.grip(batch), axis=1) > task.mug.reach_m + self.MARGIN_M
        on_peg = task.on_peg(batch)
        at_tip = np.linalg.norm(task.tip_from_handle(batch), axis=1) < self.AT_TIP_M
        self._lifted[running] |= above_table[running]
        self._at_peg[running] |= (on_peg | (above_table & at_tip))[running]
        self._unfinished[running] = (on_peg | (above_table & ~away))[running]

        hung = running & on_peg & away
        self.held(hung, time_s)

    def failures(self, running: np.ndarray) -> list[str]:
        kinds = [
            ("not_grasped", ~self._lifted),
            ("not_released", self._unfinished),
            ("missed", self._at_peg),
        ]
        return self.named(running, kinds, "dropped")
