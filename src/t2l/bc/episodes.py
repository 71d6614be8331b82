"""Closed-loop episodes: one in each simulation of a batch, all stepping together."""

import numpy as np

from t2l.actions import Control
from t2l.sim import make_batch
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated


class Episodes:
    """From given starts until success, divergence or the task's horizon.

    An episode that is over is not simulated further; it keeps what it showed last.

    Args:
        control: of a cell, in the task's model.
        starts: (n, nq).
        decimation: timesteps that each action is held for.

    Attributes:
        ticks: actions that an episode has at most.
        tick: actions that were taken.
        running: (n,) bool, those that are not over.
        sound: (n,) bool, those that have not diverged.
        qpos: (n, nq).
        observation: (n, nobs) float32.
    """

    def __init__(
        self,
        task: Demonstrated,
        control: Control,
        starts: np.ndarray,
        decimation: int,
        threads: int = 1,
    ):
        n = len(starts)
        self.task, self._control, self._decimation = task, control, decimation
        self._tick_s = decimation * TIMESTEP_S
        self.ticks, self.tick = round(task.horizon_s / self._tick_s), 0
        controller = control.controller
        self._batch = make_batch(task.model, n, threads)
        controller.install(self._batch)
        task.reset(self._batch, starts)
        self._monitor = task.monitor(n)
        self.sound = np.ones(n, dtype=bool)
        self.running = self.sound.copy()
        self.qpos = self._batch.qpos.copy()
        self.observation = task.observe(self._batch).astype(np.float32)
        opened = np.tile(task.opened, (n, 1))
        self._sent = np.concatenate([controller.measured(self._batch), opened], axis=1)

    @property
    def success_time_s(self) -> np.ndarray:
        """(n,) when each became a success, NaN where it has not."""
        return self._monitor.success_time_s

    @property
    def success(self) -> np.ndarray:
        """(n,) bool."""
        return ~np.isnan(self.success_time_s)

    def failures(self) -> list[str]:
        """As `Monitor.failures`; final where an episode is over."""
        return self._monitor.failures(self.sound)

    def step(self, action: np.ndarray) -> np.ndarray:
        """Hold an action (n, naction + ngripper); the command (n, ncommand + ngripper) it meant."""
        controller, actions = self._control.controller, self._control.actions
        width = len(controller.command_names)
        action, gripper = np.split(action, [len(actions.names)], axis=1)
        arm = actions.command(action, controller.measured(self._batch), self._sent[:, :width])
        command = np.concatenate([arm, gripper], axis=1)
        over = ~self.running
        # a policy that answers NaN has failed; its simulation must not be fed one
        self.running &= np.isfinite(command).all(axis=1)
        # what is over is sent what it was sent last
        self._sent = np.where(self.running[:, None], command, self._sent)
        self.task.command_grippers(self._batch.ctrl, self._sent[:, width:])
        controller.step(self._batch, self._sent[:, :width], self.running, self._decimation)
        self.sound &= self.running | over
        self.tick += 1
        self._monitor.update(self._batch, self.tick * self._tick_s, self.running)
        self.running &= ~self.success & (self.tick < self.ticks)
        sound = self.sound[:, None]
        self.qpos = np.where(sound, self._batch.qpos, self.qpos)
        observation = self.task.observe(self._batch).astype(np.float32)
        self.observation = np.where(sound, observation, self.observation)
        return command
