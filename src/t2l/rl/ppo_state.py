"""All that the further learning of a PPO of stable-baselines3 depends on, between two rollouts.

One that was made alike goes on from it to the same digits. `PPO.save` keeps neither environments
nor random numbers.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.running_mean_std import RunningMeanStd


def state_of(model: PPO) -> dict[str, Any]:
    """Networks, optimiser, statistics, environments, and the state of every random number."""
    normal = model.get_vec_normalize_env()
    return {
        "parameters": model.get_parameters(),
        "steps": model.num_timesteps,
        "seen": model._last_obs,
        "starts": model._last_episode_starts,
        "returns": normal.returns,
        "statistics": [[each.mean, each.var, each.count] for each in _statistics(model)],
        "environments": normal.unwrapped.state(),
        "torch": torch.get_rng_state(),
        # of the order of samples in a minibatch
        "numpy": json.dumps(np.random.get_state(legacy=False), default=np.ndarray.tolist),
    }


def restore(model: PPO, state: Mapping[str, Any]) -> None:
    """Go on from a state; `learn` is then to be told not to reset the number of steps."""
    normal = model.get_vec_normalize_env()
    model.set_parameters(state["parameters"])
    model.num_timesteps = state["steps"]
    model._last_obs, model._last_episode_starts = state["seen"].numpy(), state["starts"].numpy()
    normal.returns = state["returns"].numpy()
    for each, (mean, var, count) in zip(_statistics(model), state["statistics"], strict=True):
        each.mean, each.var, each.count = np.asarray(mean), np.asarray(var), count
    normal.unwrapped.restore(state["environments"])
    torch.set_rng_state(state["torch"])
    np.random.set_state(json.loads(state["numpy"]))


def _statistics(model: PPO) -> list[RunningMeanStd]:
    normal = model.get_vec_normalize_env()
    return [normal.obs_rms, normal.ret_rms] if normal.norm_obs else [normal.ret_rms]
