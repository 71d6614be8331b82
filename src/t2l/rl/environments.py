"""A task as a stable-baselines3 VecEnv: all environments are one batch of simulations."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from t2l.actions import ActionSpace
from t2l.environment.environment import Environment
from t2l.environment.limits import NAMES
from t2l.gains import Cell
from t2l.sim.training_simulator import Parameters
from t2l.tasks import Rewarded


class Environments(Environment, VecEnv):
    """`n` robots at a task, each with a goal of its own; see `Environment`.

    An episode ends by truncation, or by a termination of its task. The info of one that ends holds
    `success`, and by the name of each constraint whether the episode violated it.
    """

    def __init__(
        self,
        task: Rewarded,
        cell: Cell,
        parameters: Parameters,
        actions: ActionSpace,
        n: int,
        seed: int,
        randomisation: float = 0.0,
        **of_world: Any,
    ):
        """See `Environment`.

        Args:
            cell: the gains that the robot's controller is given.
            parameters: of the identified simulator, (njoint,) each.
            randomisation: each environment's parameters differ by up to this fraction.
        """
        self.cell, self.generator = cell, np.random.default_rng(seed)
        drawn = randomised(parameters, n, randomisation, self.generator)
        Environment.__init__(
            self, task, cell.kp, cell.kd, drawn, actions, [self.generator], n, **of_world
        )
        self.render_mode = None
        self._infos: list[dict[str, Any]] = [{} for _ in range(n)]
        VecEnv.__init__(
            self,
            n,
            spaces.Box(-np.inf, np.inf, (self.observation_size,), np.float32),
            spaces.Box(-self.bound, self.bound, (len(self.action_names),), np.float32),
        )

    def reset(self) -> np.ndarray:
        """See `Environment.begin`."""
        return self.begin()

    def step_async(self, actions: np.ndarray) -> None:
        """See `VecEnv`."""
        self._next = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """See `VecEnv`."""
        observation, reward, ended = self.advance(self._next)
        done, infos = np.zeros(self.num_envs, bool), self._infos
        if ended.ids.size:
            done[ended.ids], infos = True, list(self._infos)
            for i, last, success, violated, failed, jitter, effort in zip(*ended, strict=True):
                infos[i] = {
                    "terminal_observation": last,
                    "TimeLimit.truncated": not failed,
                    "success": bool(success),
                    "jitter_rad_s": float(jitter),
                    "effort": float(effort),
                    **dict(zip(NAMES, violated.tolist(), strict=True)),
                }
        return observation, reward.astype(np.float32), done, infos

    def close(self) -> None:
        """Nothing to release."""

    def get_attr(self, attr_name: str, indices=None) -> list[Any]:
        """See `VecEnv`; the environments share their attributes."""
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices=None) -> None:
        """See `VecEnv`."""
        raise AttributeError("the environments of a batch share their attributes")

    def env_method(self, method_name: str, *method_args, indices=None, **method_kwargs):
        """See `VecEnv`."""
        raise AttributeError("the environments of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class, indices=None) -> list[bool]:
        """See `VecEnv`."""
        return [False] * len(list(self._get_indices(indices)))


def randomised(
    parameters: Mapping[str, np.ndarray],
    n: int,
    fraction: float,
    generator: np.random.Generator,
) -> Parameters:
    """Parameters (n, njoint), each up to `fraction` more or less."""
    return {
        name: values * generator.uniform(1 - fraction, 1 + fraction, (n, len(values)))
        for name, values in parameters.items()
    }
