"""What lerobot's own policies have in common here.

Networks, losses, optimisers and normalisation are lerobot's, and so are the names of their
settings; the windows of episodes are ours. Importing lerobot takes seconds: only what trains or
acts by such a policy does it, through `t2l.policies.lerobot_network`.
"""

import logging
import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import Field

from t2l.policies.policy import ClonedPolicy, Episode
from t2l.policies.validation import prediction_mse
from t2l.policies.windows import around
from t2l.typed import Integer, Typed, check

if TYPE_CHECKING:
    import pandas as pd

    from t2l.policies.lerobot_network import LeRobotNetwork

log = logging.getLogger(__name__)

# steps that an epoch is judged by: one that is denoised takes as long as several trained on
JUDGED = 500


class Features(Typed):
    """Numbers in lerobot's features of one step; both policies want to see the first two."""

    robot: Integer = Field(ge=1, lt=2**31, description="in observation.state")
    environment: Integer = Field(ge=1, lt=2**31, description="in observation.environment_state")
    action: Integer = Field(ge=1, lt=2**31, description="in action")


class Keys(Typed):
    """Of lerobot's configuration of a policy, under its names, and what else makes the policy."""

    @property
    def stacked(self) -> int:
        """Observations that stand side by side in what lerobot takes for one."""
        return 1

    @abstractmethod
    def configuration(self) -> dict[str, Any]:
        """What lerobot's class of configurations is made of, but for features."""


class LeRobotSettings(Typed):
    """Of a training, which lerobot leaves to whoever trains."""

    epochs: Integer = Field(50, ge=1, le=10_000, description="passes over the training episodes")
    batch_size: Integer = Field(256, ge=1, le=65_536, description="windows per gradient step")


def side_by_side(observations: np.ndarray, robot_size: int) -> np.ndarray:
    """Observations (..., m, nobs) as one (..., m nobs), what is the robot's first."""
    parts = np.split(observations, [robot_size], axis=-1)
    return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)


def _stacked(episode: Episode, m: int) -> Episode:
    """An episode of which every observation holds the m latest."""
    past, _ = around([len(episode.action)], range(1 - m, 1))
    observation = side_by_side(episode.observation[past], episode.robot_size)
    return replace(episode, observation=observation, robot_size=m * episode.robot_size)


class LeRobotPolicy(ClonedPolicy):
    """A policy of lerobot's.

    Attributes:
        kind: lerobot's name of it.
        keys: what may be set of its configuration; `settings` has them too.
    """

    kind: str
    keys: type[Keys]
    packages = ("lerobot",)
    needs = ("robot", "environment")

    def __init__(self, network: "LeRobotNetwork", features: Features, keys: Keys):
        """See the class; `network` is of these features and keys."""
        self.network, self._features, self._keys = network.eval(), features, keys
        self.observation_size = features.robot + features.environment
        self.action_size = features.action
        self.history, self.chunk = network.history + keys.stacked - 1, network.chunk
        self._asked = 0

    @classmethod
    def _network(cls, features: Features, keys: Keys, device: str = "cpu") -> "LeRobotNetwork":
        from t2l.policies.lerobot_network import LeRobotNetwork

        seen = {"robot": features.robot, "environment": features.environment}
        stacked = features.model_copy(update={k: n * keys.stacked for k, n in seen.items()})
        return LeRobotNetwork(cls.kind, stacked, keys.configuration(), device)

    @classmethod
    def fit(
        cls,
        training: Sequence[Episode],
        validation: Sequence[Episode],
        settings: LeRobotSettings,
        seed: int,
        threads: int = 1,
    ) -> "tuple[Self, pd.DataFrame]":
        """See `ClonedPolicy.fit`.

        The training loss is lerobot's. The validation loss is the mean squared error of actions
        over their variance in the training episodes, as that of a `ChunkPolicy`.
        """
        import pandas as pd
        import torch

        from t2l.policies.lerobot_training import epochs
        from t2l.policies.training import reproducible

        keys = cls.keys(**settings.model_dump(include=set(cls.keys.model_fields)))
        robot = training[0].robot_size
        features = check(
            Features,
            {
                "robot": robot,
                "environment": training[0].observation.shape[1] - robot,
                "action": training[0].action.shape[1],
            },
        )
        training = [_stacked(episode, keys.stacked) for episode in training]
        rows, start = [], time.monotonic()
        with reproducible(threads) as device:
            # weights are drawn on the processor, so that they are the same on every device
            torch.manual_seed(seed)
            network = cls._network(features, keys, device.type).to(device)
            network.normalise_by(
                np.concatenate([e.observation for e in training]),
                np.concatenate([e.action for e in training]),
            )
            variance = network.action_std.cpu().numpy() ** 2
            for epoch, loss in enumerate(epochs(network, training, settings, seed), 1):
                policy = cls(network, features, keys)
                judged = float((prediction_mse(policy, validation, JUDGED) / variance).mean())
                rows.append((epoch, loss, judged))
                left_s = (time.monotonic() - start) / epoch * (settings.epochs - epoch)
                log.info(
                    "epoch %d of %d: training loss %.5f, validation loss %.5f, %.0f s left",
                    *(epoch, settings.epochs, loss, judged, left_s),
                )
        columns = ["epoch", "training_loss", "validation_loss"]
        return cls(network, features, keys), pd.DataFrame(rows, columns=columns)

    def act(self, history: np.ndarray) -> np.ndarray:
        """See `Policy.act`; the same calls draw the same numbers."""
        self._asked += 1
        seen = np.arange(self.network.history)[:, None] + np.arange(self._keys.stacked)
        history = side_by_side(history[:, seen], self._features.robot)
        return self.network.act(history, seed=self._asked)

    def tensors(self) -> dict[str, np.ndarray]:
        """See `Policy.tensors`."""
        return {name: value.cpu().numpy() for name, value in self.network.state_dict().items()}

    def metadata(self) -> dict[str, Any]:
        """See `Policy.metadata`."""
        return {"features": self._features.model_dump(), "config": self._keys.model_dump()}

    @classmethod
    def restored(cls, tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> Self:
        """See `Policy.restored`."""
        import torch

        from t2l.policies.state import fitting

        features = check(Features, metadata["features"])
        keys = check(cls.keys, metadata["config"])
        # without memory, however large it says it is
        with torch.device("meta"):
            state = fitting(tensors, cls._network(features, keys).state_dict())
        with torch.random.fork_rng():
            network = cls._network(features, keys)
        network.load_state_dict(state)
        return cls(network, features, keys)

    def save_pretrained(self, folder: Path | str) -> None:
        """Write what lerobot reads as a pretrained policy, with its processors."""
        self.network.save_pretrained(folder)
