"""When one block stands on another."""

from typing import TYPE_CHECKING

import numpy as np
from mujoco.batch import Batch

from t2l.tasks.held_monitor import HeldMonitor

if TYPE_CHECKING:
    from t2l.tasks.block_stack import BlockStack


class StackMonitor(HeldMonitor):
    """Success: red stands on blue, at rest, let go, for a fifth of a second.

    Failure kinds: `not_grasped` (red never left the table), `dropped` (it did, and lies on the
    table at the end), `not_released` (still in the hand), `misplaced` (let go above the table
    and not on blue), `diverged`.
    """

    HOLD_S = 0.2
    HEIGHT_TOLERANCE_M = 0.005
    REST_SPEED_M_S = 0.05
    LIFTED_M = 0.02

    def __init__(self, task: "BlockStack", carried: str, nsim: int):
        super().__init__(nsim)
        self.task, self._carried = task, carried
        self._lifted = np.zeros(nsim, dtype=bool)
        self._on_table = np.ones(nsim, dtype=bool)
        self._released = np.ones(nsim, dtype=bool)

    def update(self, batch: Batch, time_s: float, running: np.ndarray) -> None:
        task = self.task
        poses = task.block_poses(batch.bind("qpos"))
        red, blue = poses[:, 0, :3], poses[:, 1, :3]
        grip = batch.bind("site_xpos")[:, task.tool_sites[0]]
        address = task.model.joint(self._carried).dofadr[0]
        speed = np.linalg.norm(batch.bind("qvel")[:, address : address + 3], axis=1)

        height = red[:, 2] - task.block_size_m / 2
        self._lifted[running] |= height[running] > self.LIFTED_M
        self._on_table[running] = height[running] < self.LIFTED_M / 2
        self._released[running] = np.linalg.norm(red - grip, axis=1)[running] > task.block_size_m
        offset = red - blue
        stacked = (
            running
            & self._released
            & (np.linalg.norm(offset[:, :2], axis=1) < task.placement_tolerance_m)
            & (np.abs(offset[:, 2] - task.block_size_m) < self.HEIGHT_TOLERANCE_M)
            & (speed < self.REST_SPEED_M_S)
        )
        self.held(stacked, time_s)

    def failures(self, running: np.ndarray) -> list[str]:
        kinds = [
            ("not_grasped", ~self._lifted),
            ("dropped", self._on_table),
            ("not_released", ~self._released),
        ]
        return self.named(running, kinds, "misplaced")
