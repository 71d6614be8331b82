"""A task as a gymnasium vector environment: all its episodes are one batch of simulations."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from lerobot_env_t2l.pictures import Pictures
from t2l.actions import Control
from t2l.bc.episodes import PolicyEpisodes
from t2l.demos.dataset import ACTION, ENVIRONMENT, STATE, policy_features
from t2l.errors import ConfigurationError
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated
from t2l.tasks.cameras import Cameras

# what lerobot calls the features of a data set where an environment gives them
OBSERVED_AS = {STATE: "agent_pos", ENVIRONMENT: "environment_state"}
PIXELS = "pixels"  # and the pictures of each camera


class BatchEnvironment(VectorEnv):
    """`n` episodes of a task under one controller, stepping together as in `t2l.bc.rollout`.

    The reward is 1 with the action that brings success, else 0. An episode that is over stays as it
    is until `reset`, which begins all anew. When episodes end, the info holds `final_info`: of each
    `is_success` and the kind of `failure`, where gymnasium's own vector environments have them.

    Args:
        control: of a cell, in the task's model.
        decimation: timesteps that an action is held for.
        picture_hz: new pictures a second in videos; 0 draws only how an episode begins and ends.
        cameras: that a policy sees by, in place of the environment's state; none without names.
        size_px: of their square pictures.

    Attributes:
        task: its name.
        task_description: it in words, as data sets have it.
    """

    def __init__(
        self,
        task: Demonstrated,
        control: Control,
        n: int,
        decimation: int,
        threads: int = 1,
        picture_hz: int = 0,
        cameras: Sequence[str] = (),
        size_px: int = 0,
    ):
        self._task, self._control, self.num_envs = task, control, n
        self._decimation, self._threads = decimation, threads
        self.task, self.task_description = task.name, task.instruction
        fps = round(1 / (decimation * TIMESTEP_S))
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": fps,
            "autoreset_mode": AutoresetMode.DISABLED,
        }
        self.render_mode = "rgb_array"
        features = policy_features(task, control.actions.names, cameras, size_px)
        shown = {
            name: _unbounded(features[key]["shape"])
            for key, name in OBSERVED_AS.items()
            if key in features
        }
        self._cameras = None
        if cameras:
            self._cameras = Cameras(task.spec(visual=True).compile(), cameras, size_px)
            self._seen = np.empty((n, *self._cameras.shape), np.uint8)
            picture = spaces.Box(0, 255, self._cameras.shape[1:], np.uint8)
            shown[PIXELS] = spaces.Dict(dict.fromkeys(cameras, picture))
        self.single_observation_space = spaces.Dict(shown)
        self.single_action_space = _unbounded(features[ACTION]["shape"])
        self.observation_space = batch_space(self.single_observation_space, n)
        self.action_space = batch_space(self.single_action_space, n)
        self._pictures = Pictures(task, n, max(1, round(fps / picture_hz)) if picture_hz else 0)

    @property
    def _max_episode_steps(self) -> int:
        """As lerobot asks for it."""
        return self._episodes.ticks

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Begin every episode at a start that its own seed draws.

        Args:
            seed: of each episode, or of the first one, which the others' follow.
            options: not used; gymnasium's `reset_mask` is refused.

        Raises:
            ConfigurationError: only some of the episodes were to begin anew.
        """
        if "reset_mask" in (options or {}):
            raise ConfigurationError("reset: found reset_mask; allowed: to begin all episodes anew")
        if seed is None:
            seed = self.np_random.integers(2**31, size=self.num_envs)
        elif isinstance(seed, int):
            seed = range(seed, seed + self.num_envs)
        starts = [self._task.sample_starts(np.random.default_rng(one), 1) for one in seed]
        self._episodes = PolicyEpisodes(
            self._task, self._control, np.concatenate(starts), self._decimation, self._threads
        )
        self._pictures.begin(self._episodes)
        return self._observation(self._episodes.running), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Hold an action (n, naction + ngripper) of the policy in each episode.

        Raises:
            ConfigurationError: the actions are not this environment's.
        """
        if np.shape(actions) != self.action_space.shape:
            raise ConfigurationError(
                f"action: found an array of shape {np.shape(actions)}; allowed: "
                f"{self.action_space.shape}, one action for each episode"
            )
        episodes, before = self._episodes, self._episodes.running.copy()
        if before.any():
            episodes.step(actions)
        ended = before & ~episodes.running
        self._pictures.follow(before)
        terminated = ~episodes.running & (episodes.success | ~episodes.sound)
        truncated = ~episodes.running & ~terminated
        reward = (ended & episodes.success).astype(float)
        return self._observation(before), reward, terminated, truncated, self._info(ended)

    def _observation(self, moved: np.ndarray) -> dict[str, Any]:
        """What all episodes show, of which those in the mask `moved` (n,) have changed."""
        own = self._task.robot_observation_size
        state, environment = np.split(self._episodes.observation, [own], axis=1)
        if self._cameras is None:
            return {OBSERVED_AS[STATE]: state, OBSERVED_AS[ENVIRONMENT]: environment}
        self._seen[moved] = self._cameras.pictures(self._episodes.qpos[moved])
        views = zip(self._cameras.names, self._seen.swapaxes(0, 1), strict=True)
        # copies, as gymnasium's own environments give
        return {OBSERVED_AS[STATE]: state, PIXELS: {name: seen.copy() for name, seen in views}}

    def _info(self, ended: np.ndarray) -> dict[str, Any]:
        if not ended.any():
            return {}
        final = {
            "is_success": self._episodes.success & ended,
            "failure": np.where(ended, self._episodes.failures(), None),
        }
        masks = {f"_{key}": ended for key in final}
        return {"final_info": final | masks, "_final_info": ended}

    def render(self) -> Pictures:
        """A picture (height, width, 3) uint8 of each episode, drawn when it is taken."""
        return self._pictures

    def call(self, name: str) -> Sequence[Any]:
        """What each episode answers to a name, as gymnasium's own vector environments do."""
        return self.render() if name == "render" else (getattr(self, name),) * self.num_envs

    def get_attr(self, name: str) -> Sequence[Any]:
        """As `call`."""
        return self.call(name)

    def close_extras(self, **kwargs: Any) -> None:
        """Release what draws."""
        self._pictures.close()
        if self._cameras is not None:
            self._cameras.close()


def _unbounded(shape: tuple[int, ...]) -> spaces.Box:
    return spaces.Box(-np.inf, np.inf, shape, np.float32)
