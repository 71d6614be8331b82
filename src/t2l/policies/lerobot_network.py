"""A policy of lerobot's with its processors, made of what t2l has: physical units outside."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from t2l.policies.lerobot_policy import Features

STATISTICS = ("mean", "std", "min", "max")


class LeRobotNetwork(nn.Module):
    """Histories (n, history, nobs) to chunks (n, chunk, nact).

    Buffers hold the statistics that lerobot's processors normalise by, as PART_STATISTIC, the
    parts being those of `Features`.

    Attributes:
        policy: lerobot's.
    """

    def __init__(self, kind: str, features: Features, keys: Mapping[str, Any], device: str):
        """Weights are drawn by torch's generator.

        Args:
            kind: lerobot's name of the policy.
            keys: of its configuration.
            device: that it will be on.
        """
        from lerobot.configs import FeatureType, PolicyFeature
        from lerobot.policies.factory import get_policy_class, make_policy_config
        from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_STATE

        super().__init__()
        self.features = features
        self._names = {"robot": OBS_STATE, "environment": OBS_ENV_STATE, "action": ACTION}
        config = make_policy_config(
            kind,
            input_features={
                OBS_STATE: PolicyFeature(FeatureType.STATE, (features.robot,)),
                OBS_ENV_STATE: PolicyFeature(FeatureType.ENV, (features.environment,)),
            },
            output_features={ACTION: PolicyFeature(FeatureType.ACTION, (features.action,))},
            device=device,
            push_to_hub=False,
            **keys,
        )
        # unless told, lerobot leaves the environment's state as it is, and blocks move centimetres
        config.normalization_mapping["ENV"] = config.normalization_mapping["STATE"]
        self.policy = get_policy_class(kind)(config)
        for part, size in features.model_dump().items():
            for statistic in STATISTICS:
                self.register_buffer(f"{part}_{statistic}", torch.zeros(size))
        self._processors = None

    @property
    def history(self) -> int:
        """Observations that it sees."""
        return len(self.policy.config.observation_delta_indices or [0])

    @property
    def chunk(self) -> int:
        """Actions that it answers with."""
        return self.policy.config.n_action_steps

    def normalise_by(self, observations: np.ndarray, actions: np.ndarray) -> None:
        """Take statistics from data (n, size); an element that never changes keeps scale 1."""
        robot, environment = np.split(observations, [self.features.robot], axis=1)
        parts = {"robot": robot, "environment": environment, "action": actions}
        for part, values in parts.items():
            values = values.astype(float)
            mean, std, low, high = (f(values, axis=0) for f in (np.mean, np.std, np.min, np.max))
            still = std <= 1e-4
            found = mean, np.where(still, 1, std), low - still, high + still
            for statistic, value in zip(STATISTICS, found, strict=True):
                getattr(self, f"{part}_{statistic}").copy_(torch.as_tensor(value))
        self._processors = None

    def processors(self) -> tuple[Any, Any]:
        """lerobot's, which normalise what goes in, and give what comes out its units."""
        if self._processors is None:
            from lerobot.policies.factory import make_pre_post_processors

            statistics = {
                name: {s: getattr(self, f"{part}_{s}") for s in STATISTICS}
                for part, name in self._names.items()
            }
            self._processors = make_pre_post_processors(
                self.policy.config, dataset_stats=statistics
            )
        return self._processors

    def normalised(self, observation: np.ndarray, action: np.ndarray | None = None) -> dict:
        """Observations (..., nobs), and actions, as lerobot's policy takes them, by feature."""
        robot, environment = np.split(observation, [self.features.robot], axis=-1)
        parts = {"robot": robot, "environment": environment, "action": action}
        batch = {
            self._names[part]: torch.as_tensor(values, dtype=torch.float32)
            for part, values in parts.items()
            if values is not None
        }
        done = self.processors()[0](batch)
        return {name: done[name] for name in batch}

    def act(self, history: np.ndarray, seed: int) -> np.ndarray:
        """Action chunks for histories.

        Args:
            seed: of what is drawn; the generators of others stay as they are.
        """
        if self.policy.config.observation_delta_indices is None:
            history = history[:, -1]
        device = self.action_mean.device
        with torch.no_grad(), torch.random.fork_rng([device] if device.type == "cuda" else []):
            torch.manual_seed(seed)
            chunk = self.policy.predict_action_chunk(self.normalised(history))
            return self.processors()[1](chunk).numpy()

    def save_pretrained(self, folder: Path | str) -> None:
        """Write lerobot's files of a pretrained policy."""
        for part in (self.policy, *self.processors()):
            part.save_pretrained(folder)
