"""A task as a gymnasium vector environment, so that any trainer that takes one runs on it.

from t2l.environment.vector import make_vector

environments = make_vector(task, Cell(512, 24), action_scale=(0.2, 0.1), n=512)
observation, _ = environments.reset(seed=0)
observation, reward, terminated, truncated, info = environments.step(actions)
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from t2l.environment.environment import Environment
from t2l.environment.ideal import ideal_plant
from t2l.environment.interface import action_space, scale_per_joint
from t2l.environment.limits import NAMES
from t2l.gains import Cell
from t2l.sim.training_simulator import Parameters
from t2l.tasks import Rewarded


class VectorView(VectorEnv):
    """All robots of an environment on the processor.

    An episode begins anew in the step that ends the one before. Its last observation is in
    `info["final_obs"]`; `info["success"]` says whether it was a success, and under the name of each
    limit whether it exceeded it.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(self, environment: Environment):
        self.environment, self.num_envs = environment, environment.rows
        bound, size = environment.bound, (len(environment.action_names),)
        seen = (environment.observation_size,)
        self.single_observation_space = spaces.Box(-np.inf, np.inf, seen, np.float32)
        self.single_action_space = spaces.Box(-bound, bound, size, np.float32)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """See `VectorEnv`; a seed is of the starts and goals of all robots together."""
        super().reset(seed=seed)
        if seed is not None:
            streams = np.random.SeedSequence(seed).spawn(len(self.environment.generators))
            self.environment.generators = [np.random.default_rng(stream) for stream in streams]
        return self.environment.begin(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """See `VectorEnv`."""
        observation, reward, ended = self.environment.advance(actions)
        terminated, over = np.zeros((2, self.num_envs), bool)
        terminated[ended.ids], over[ended.ids] = ended.failed, True
        info: dict[str, Any] = {}
        if ended.ids.size:
            last = np.full(self.num_envs, None, object)
            for i, own in zip(ended.ids, ended.observation, strict=True):
                last[i] = own
            told = {"success": ended.success, **dict(zip(NAMES, ended.violated.T, strict=True))}
            info = {"final_obs": last, "_final_obs": over}
            for name, values in told.items():
                info[name], info[f"_{name}"] = np.zeros(self.num_envs, bool), over
                info[name][ended.ids] = values
        return observation, reward, terminated, over & ~terminated, info


def make_vector(
    task: Rewarded,
    cell: Cell,
    action_scale: tuple[float, ...],
    n: int,
    horizon_s: float = 5.0,
    policy_rate_hz: float = 50.0,
    rate_hz: float = 200.0,
    actions: Mapping[str, Any] | None = None,
    parameters: Parameters | None = None,
    **of_environment: Any,
) -> VectorView:
    """`n` robots at a task under the gains of a cell.

    Args:
        action_scale: α of each of the robot's groups of joints, rad.
        rate_hz: of the physics.
        actions: what they mean, as in that section of a configuration; relative to q without.
        parameters: of the simulator, `ideal_plant` without.
        of_environment: other arguments of `Environment`.

    Raises:
        ConfigurationError: an action scale or a rate is not allowed.
    """
    scale = scale_per_joint(action_scale, task.robot)
    return VectorView(
        Environment(
            task, cell.kp, cell.kd, parameters or ideal_plant(task, cell),
            action_space(actions or {"kind": "joint_delta"}, task.robot, scale),
            [np.random.default_rng(0)], n, horizon_s, policy_rate_hz, rate_hz,
            **{"staggered": False, **of_environment},
        )
    )  # fmt: skip
