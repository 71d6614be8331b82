"""A task of one's own: the scene of Block Stack, solved when the red block is held up."""

import numpy as np

from t2l.tasks import Monitor
from t2l.tasks.block_stack import BlockStack


class Lift(BlockStack):
    """Lift the red block off the table."""

    name = "lift"
    instruction = "Lift the red block."

    def waypoints(self, rng, qpos):
        """As in Block Stack, up to where the block is lifted."""
        (legs,) = super().waypoints(rng, qpos)
        return [legs[:4]]

    def monitor(self, nsim):
        return LiftMonitor(self, nsim)


class LiftMonitor(Monitor):
    """Success: the block is 0.08 m above the table; else it was `not_lifted`."""

    HEIGHT_M = 0.08

    def __init__(self, task, nsim):
        self.task = task
        self.success_time_s = np.full(nsim, np.nan)

    def update(self, batch, time_s, running):
        red = self.task.block_poses(batch.bind("qpos"))[:, 0]
        done = running & (red[:, 2] > self.HEIGHT_M) & np.isnan(self.success_time_s)
        self.success_time_s[done] = time_s

    def failures(self, running):
        done = ~np.isnan(self.success_time_s)
        return np.select([done, ~running], ["", "diverged"], "not_lifted").tolist()
