"""Episodes in which a policy acts."""

import numpy as np

from t2l.actions import Control
from t2l.environment.episodes import Episodes
from t2l.tasks import Demonstrated


class PolicyEpisodes(Episodes):
    """Until success, divergence or the task's horizon.

    An episode that is over is not simulated further; it keeps what it showed last.

    Args:
        control: of a cell, in the task's model.
        starts: (n, nq).
        decimation: timesteps that each action is held for.

    Attributes:
        ticks: actions that an episode has at most.
        running: (n,) bool, those that are not over.
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
        super().__init__(task, control.controller, starts, decimation, threads)
        self._control, self.ticks = control, round(task.horizon_s / self.tick_s)
        self.running = self.sound.copy()
        self.qpos = self.batch.qpos.copy()
        self.observation = task.observe(self.batch).astype(np.float32)
        opened = np.tile(task.opened, (len(starts), 1))
        self._sent = np.concatenate([control.controller.measured(self.batch), opened], axis=1)

    @property
    def success(self) -> np.ndarray:
        """(n,) bool."""
        return ~np.isnan(self.success_time_s)

    def step(self, action: np.ndarray) -> np.ndarray:
        """Hold an action (n, naction + ngripper); the command (n, ncommand + ngripper) it meant."""
        controller, actions = self._control.controller, self._control.actions
        width = len(controller.command_names)
        action, gripper = np.split(action, [len(actions.names)], axis=1)
        arm = actions.command(action, controller.measured(self.batch), self._sent[:, :width])
        command = np.concatenate([arm, gripper], axis=1)
        # a policy that answers NaN has failed; its simulation must not be fed one
        answered = np.isfinite(command).all(axis=1)
        self.sound &= answered | ~self.running
        self.running &= answered
        # what is over is sent what it was sent last
        self._sent = np.where(self.running[:, None], command, self._sent)
        self.hold(self._sent[:, :width], self._sent[:, width:], self.running)
        self.judge(self.running)
        self.running &= ~self.success & (self.tick < self.ticks)
        sound = self.sound[:, None]
        self.qpos = np.where(sound, self.batch.qpos, self.qpos)
        observation = self.task.observe(self.batch).astype(np.float32)
        self.observation = np.where(sound, observation, self.observation)
        return command
