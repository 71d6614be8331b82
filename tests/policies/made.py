"""Small policies, trained on next to nothing."""

import json
from typing import Any

import numpy as np

from t2l.policies import POLICIES, Episode
from t2l.policies.captured import Captured
from t2l.policies.gaussian_mlp import GaussianMLP
from t2l.policies.validation import split


class Reused(Captured):
    """On a processor what a CUDA graph is on a GPU: it reads and writes the same tensors anew."""

    def __call__(self, *arguments, **named):
        """See `Captured`."""
        if self._graph is None:
            self._graph = (
                [argument.clone() for argument in arguments],
                {name: argument.clone() for name, argument in named.items()},
            )
            self._function(*arguments, **named)
            self._results = tuple(result.clone() for result in self._function(*arguments, **named))
        own, own_named = self._graph
        for kept, given in zip(
            [*own, *own_named.values()], [*arguments, *named.values()], strict=True
        ):
            kept.copy_(given)
        for kept, result in zip(self._results, self._function(*own, **own_named), strict=True):
            kept.copy_(result)
        return self._results


def episodes(count: int = 10, length: int = 60) -> list[Episode]:
    """A law that a policy can learn: the action is a fixed function of the observation."""
    rng = np.random.default_rng(0)
    made = []
    for _ in range(count):
        observation = np.cumsum(0.1 * rng.normal(size=(length, 4)), axis=0)
        action = np.stack([np.sin(observation[:, 0]), 5 + observation[:, 1]], axis=1)
        made.append(Episode(observation.astype(np.float32), action.astype(np.float32)))
    return made


# policies with a network from history to chunk, and what makes it small
CHUNK_POLICIES = {
    "chunk_cvae": {"latent": 2, "hidden": [32, 32]},
    "chunk_diffusion": {"hidden": [64, 64]},
    "chunk_regression": {"hidden": [32, 32]},
    "chunk_transformer": {"latent": 2, "layers": 1, "width": 16, "heads": 2},
}


def settings(kind: str = "chunk_cvae", **changes):
    """Of a training of seconds."""
    small = {
        "history": 2, "chunk": 3, "epochs": 30, "batch_size": 64, "learning_rate": 3e-3,
        "weight_decay": 0.0, "observation_noise": 0.0,
    }  # fmt: skip
    return POLICIES.find(kind).settings(**small | CHUNK_POLICIES[kind] | changes)


def fitted(given, seed: int = 1, kind: str = "chunk_cvae", **changes):
    """A policy and its losses; a fifth of the episodes is held out."""
    own = settings(kind, **changes)
    return POLICIES.find(kind).fit(*split(given, 0.2, seed), own, seed)


def chunk_policy(kind: str = "chunk_cvae", **changes):
    """A policy after one epoch."""
    return fitted(episodes(), kind=kind, epochs=1, **changes)[0]


def gaussian_mlp() -> GaussianMLP:
    """Of two layers, for observations (n, 5) and actions (n, 3)."""
    draw = np.random.default_rng(0).normal
    return GaussianMLP(
        mean=draw(size=5),
        deviation=1 + draw(size=5) ** 2,
        weights=(draw(size=(9, 5)), draw(size=(3, 9))),
        biases=(draw(size=9), draw(size=3)),
        action_scale=np.array([0.3, 0.3, 0.1]),
    )


def header(name: Any, metadata: Any) -> dict[str, str]:
    """Of a checkpoint."""
    return {"t2l_policy": json.dumps({"name": name, "metadata": metadata})}
