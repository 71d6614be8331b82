"""Episodes of a demonstrated task: one in each simulation of a batch, all stepping together.

A controller holds commands, and a monitor judges. Who steps says what is commanded, and when an
episode is over: an expert, a person, a motion that is replayed, a policy.
"""

from typing import Protocol

import numpy as np
from mujoco.batch import Batch

from t2l.sim import make_batch
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated


class Holding(Protocol):
    """What of a `t2l.sim.controllers.Controller` episodes need."""

    def install(self, batch: Batch) -> None:
        """See `Controller.install`."""

    def step(self, batch: Batch, command: np.ndarray, running: np.ndarray, nstep: int) -> None:
        """See `Controller.step`."""


class Episodes:
    """From given starts, at rest.

    Args:
        controller: in the task's model.
        starts: (n, nq).
        decimation: timesteps that each command is held for.

    Attributes:
        batch: the simulations.
        tick: commands that were held.
        tick_s: how long each is.
        sound: (n,) bool, those that have not diverged.
    """

    def __init__(
        self,
        task: Demonstrated,
        controller: Holding,
        starts: np.ndarray,
        decimation: int,
        threads: int = 1,
    ):
        n = len(starts)
        self.task, self._controller, self._decimation = task, controller, decimation
        self.tick, self.tick_s = 0, decimation * TIMESTEP_S
        self.batch = make_batch(task.model, n, threads)
        controller.install(self.batch)
        task.reset(self.batch, starts)
        self._monitor = task.monitor(n)
        self.sound = np.ones(n, dtype=bool)

    @property
    def success_time_s(self) -> np.ndarray:
        """(n,) when each became a success, NaN where it has not."""
        return self._monitor.success_time_s

    def failures(self) -> list[str]:
        """As `Monitor.failures`; final where an episode is over."""
        return self._monitor.failures(self.sound)

    def hold(
        self, command: np.ndarray, gripper: np.ndarray, running: np.ndarray | None = None
    ) -> None:
        """Hold commands (n, ncommand) and gripper commands (n, ngripper) for a tick.

        Args:
            running: (n,) bool, in which simulations; those that diverge are taken out of it. All
                that are sound without.
        """
        running = self.sound if running is None else running
        over = ~running
        self.task.command_grippers(self.batch.ctrl, gripper)
        self._controller.step(self.batch, command, running, self._decimation)
        self.sound &= running | over
        self.tick += 1

    def judge(self, watched: np.ndarray) -> None:
        """Let the monitor see the simulations `watched` (n,) bool as they are."""
        self._monitor.update(self.batch, self.tick * self.tick_s, watched)
