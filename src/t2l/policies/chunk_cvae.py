"""The policy `chunk_cvae`: a conditional variational autoencoder of action chunks.

Its network is `t2l.policies.chunk_cvae_network`; only what needs it loads torch.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field

from t2l.policies.policy import ClonedPolicy, Episode, TrainingSet
from t2l.policies.training_settings import TrainingSettings
from t2l.typed import Integer, Number, Typed, check

if TYPE_CHECKING:
    import pandas as pd

    from t2l.policies.chunk_cvae_network import ChunkCVAENetwork

# a file may say any size; none of these is as large
Size = Annotated[Integer, Field(ge=1, lt=2**31)]


class Sizes(Typed):
    """Of the network; `history` and `chunk` count policy steps."""

    observation_size: Size
    action_size: Size
    history: Size
    chunk: Size
    latent: Size
    hidden: list[Size]


class Settings(TrainingSettings):
    """Of training."""

    latent: Integer = Field(8, ge=1, le=1_000, description="size of the latent")
    # two layers of the widest side by side take 64 MB
    hidden: Annotated[
        list[Annotated[Integer, Field(ge=1, le=4_096)]], Field(min_length=1, max_length=20)
    ] = Field([256, 256, 256], description="widths of the hidden layers of encoder and decoder")
    kl_weight: Number = Field(
        0.01, ge=0, description="weight of the latent's divergence from its prior"
    )
    observation_noise: Number = Field(
        0.2,
        ge=0,
        le=100,
        description="standard deviation of noise on normalised observations while training; "
        "without it a policy copies the recent past",
    )


class ChunkCVAE(ClonedPolicy):
    """Acts by the mean of the latent's prior."""

    name = "chunk_cvae"
    settings = Settings

    def __init__(self, network: "ChunkCVAENetwork"):
        """See the class; `network` is trained."""
        self.network = network.eval()
        sizes = network.sizes
        self.observation_size, self.action_size = sizes.observation_size, sizes.action_size
        self.history, self.chunk = sizes.history, sizes.chunk

    @classmethod
    def fit(
        cls,
        training: Sequence[Episode],
        validation: Sequence[Episode],
        settings: Settings,
        seed: int,
        threads: int = 1,
    ) -> "tuple[Self, pd.DataFrame]":
        """See `ClonedPolicy.fit`.

        The table's losses are mean squared errors of normalised actions; `reconstruction` is the
        part of the training loss that is one.
        """
        (made,) = cls.fit_side_by_side([TrainingSet(training, validation, seed)], settings, threads)
        return made

    @classmethod
    def fit_side_by_side(
        cls, sets: Sequence[TrainingSet], settings: Settings, threads: int = 1
    ) -> "list[tuple[Self, pd.DataFrame]]":
        """See `ClonedPolicy.fit_side_by_side`."""
        import torch

        from t2l.policies.chunk_cvae_network import ChunkCVAENetwork
        from t2l.policies.training import Data, reproducible, train

        with reproducible(threads) as device:
            data = Data([e for s in sets for e in s.training], settings, device)
            ends = np.cumsum([sum(len(e.action) for e in s.training) for s in sets]).tolist()
            parts = [range(*span) for span in zip([0, *ends], ends, strict=False)]
            networks = []
            for part, member in zip(parts, sets, strict=True):
                torch.manual_seed(member.seed)
                sizes = Sizes(
                    observation_size=data.observation.shape[1],
                    action_size=data.action.shape[1],
                    **settings.model_dump(include={"history", "chunk", "latent", "hidden"}),
                )
                # weights are drawn on the processor, so that they are the same on every device
                network = ChunkCVAENetwork(sizes, settings.kl_weight, settings.observation_noise)
                own = slice(part.start, part.stop)
                network.to(device).normalise_by(data.observation[own], data.action[own])
                networks.append(network)
            validation = [Data(s.validation, settings, device) for s in sets]
            losses = train(networks, data, parts, validation, settings, [s.seed for s in sets])
        return [(cls(n), table) for n, table in zip(networks, losses, strict=True)]

    def act(self, history: np.ndarray) -> np.ndarray:
        """See `Policy.act`."""
        import torch

        device = self.network.action_mean.device
        with torch.inference_mode():
            observed = torch.as_tensor(history, dtype=torch.float32, device=device)
            return self.network(observed).cpu().numpy()

    def tensors(self) -> dict[str, np.ndarray]:
        """See `Policy.tensors`."""
        return {name: value.cpu().numpy() for name, value in self.network.state_dict().items()}

    def metadata(self) -> dict[str, Any]:
        """See `Policy.metadata`."""
        return self.network.sizes.model_dump()

    @classmethod
    def restored(cls, tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> Self:
        """See `Policy.restored`."""
        import torch

        from t2l.policies.chunk_cvae_network import ChunkCVAENetwork

        sizes = check(Sizes, metadata)
        # without memory, however large it says it is
        with torch.device("meta"):
            network = ChunkCVAENetwork(sizes)
        wanted = network.state_dict()
        given = {name: torch.from_numpy(array) for name, array in tensors.items()}
        for name, tensor in wanted.items():
            found = given[name]
            if (found.shape, found.dtype) != (tensor.shape, tensor.dtype):
                raise ValueError(f"{name} is {found.dtype} of {tuple(found.shape)}, "
                                 f"not {tensor.dtype} of {tuple(tensor.shape)}")  # fmt: skip
        if set(given) != set(wanted):
            raise ValueError("tensors that a network of its sizes does not have")
        network.load_state_dict(given, assign=True)
        return cls(network)
