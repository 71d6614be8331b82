"""What the policies have in common whose network goes from a window of history to a chunk.

What such a network is stands in `t2l.policies.chunk_network`; only what needs it loads torch.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field

from t2l.policies.policy import ClonedPolicy, Episode, TrainingSet
from t2l.policies.training_settings import TrainingSettings
from t2l.policies.windows import pictured
from t2l.registry import imported
from t2l.typed import Integer, Number, Typed, check

if TYPE_CHECKING:
    import pandas as pd

    from t2l.policies.chunk_network import ChunkNetwork

# a file may say any size; none of these is as large
Size = Annotated[Integer, Field(ge=1, lt=2**31)]
# two layers of the widest side by side take 64 MB
Widths = Annotated[
    list[Annotated[Integer, Field(ge=1, le=4_096)]], Field(min_length=1, max_length=20)
]


# numbers that the picture of a camera becomes: 32 places, and what is there
FEATURES = 3 * 32


class ChunkSizes(Typed):
    """Of a network; `history` and `chunk` count policy steps, `cameras` those that it sees by."""

    observation_size: Size
    action_size: Size
    history: Size
    chunk: Size
    cameras: Annotated[Integer, Field(ge=0, le=100)] = 0


class ChunkSettings(TrainingSettings):
    """Of training such a network."""

    observation_noise: Number = Field(
        0.2,
        ge=0,
        le=100,
        description="standard deviation of noise on normalised observations while training; "
        "without it a policy copies the recent past",
    )
    picture_shift_px: Integer = Field(
        0,
        ge=0,
        le=1_000,
        description="pictures are shifted while training, each by up to so many pixels either way; "
        "without it a policy learns by heart where objects were",
    )


class ChunkPolicy(ClonedPolicy):
    """A network that is trained on windows of demonstrations.

    Attributes:
        settings: what else configurations say; those in `sizes` too are the network's.
        sizes: what it takes to make the network again.
        network_class: what both make, a class, or "package.module:Class" where importing it
            would load torch in vain.
    """

    settings: type[ChunkSettings]
    sizes: type[ChunkSizes]
    chunk_setting = "chunk"
    picture_settings = ("picture_shift_px",)
    network_class: "str | type[ChunkNetwork]"
    sees_pictures = True

    def __init__(self, network: "ChunkNetwork"):
        """See the class; `network` is trained."""
        self.network = network.eval()
        sizes = network.sizes
        self.observation_size, self.action_size = sizes.observation_size, sizes.action_size
        self.history, self.chunk = sizes.history, sizes.chunk

    @classmethod
    def _network(cls, sizes: ChunkSizes, settings: ChunkSettings | None = None) -> "ChunkNetwork":
        made = cls.network_class
        return (imported(made) if isinstance(made, str) else made)(sizes, settings)

    @classmethod
    def fit(
        cls,
        training: Sequence[Episode],
        validation: Sequence[Episode],
        settings: ChunkSettings,
        seed: int,
        threads: int = 1,
    ) -> "tuple[Self, pd.DataFrame]":
        """See `ClonedPolicy.fit`.

        The validation loss is the mean squared error of normalised actions; `reconstruction` is
        the part of the training loss that is an error of what the network is to give.
        """
        (made,) = cls.fit_side_by_side([TrainingSet(training, validation, seed)], settings, threads)
        return made

    @classmethod
    def fit_side_by_side(
        cls, sets: Sequence[TrainingSet], settings: ChunkSettings, threads: int = 1
    ) -> "list[tuple[Self, pd.DataFrame]]":
        """See `ClonedPolicy.fit_side_by_side`."""
        import torch

        from t2l.policies.rows import Rows
        from t2l.policies.training import reproducible, train

        own = set(cls.sizes.model_fields) & set(cls.settings.model_fields)
        with reproducible(threads) as device:
            episodes = [e for s in sets for e in (*s.training, *s.validation)]
            pictures = pictured(episodes)
            store = None if pictures is None else torch.as_tensor(pictures.store, device=device)
            data = Rows(episodes, settings, device, store)
            training, validation = zip(
                *((data.of(s.training), data.of(s.validation)) for s in sets), strict=True
            )
            sizes = cls.sizes(
                observation_size=data.observation.shape[1],
                action_size=data.action.shape[1],
                cameras=0 if store is None else store.shape[1],
                **settings.model_dump(include=own),
            )

            def networks() -> "Iterator[ChunkNetwork]":
                for rows, member in zip(training, sets, strict=True):
                    # weights are drawn on the processor, so that they are the same on every device
                    torch.manual_seed(member.seed)
                    network = cls._network(sizes, settings)
                    network.to(device).normalise_by(data.observation[rows], data.action[rows])
                    yield network

            seeds = [s.seed for s in sets]
            made = train(networks(), data, training, validation, settings, seeds)
        return [(cls(network), losses) for network, losses in made]

    def act(self, history: np.ndarray, pictures: np.ndarray | None = None) -> np.ndarray:
        """See `Policy.act`.

        Raises:
            ValueError: pictures of another number of cameras than it sees by.
        """
        import torch

        found, wanted = 0 if pictures is None else pictures.shape[1], self.network.sizes.cameras
        if found != wanted:
            raise ValueError(f"pictures of {found} cameras for a policy that sees by {wanted}")
        device = self.network.action_mean.device
        with torch.inference_mode():
            seen = [torch.as_tensor(history, dtype=torch.float32, device=device)]
            if pictures is not None:
                seen.append(torch.as_tensor(pictures, device=device))
            return self.network(*seen).cpu().numpy()

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

        from t2l.policies.state import fitting

        sizes = check(cls.sizes, metadata)
        # without memory, however large it says it is
        with torch.device("meta"):
            network = cls._network(sizes)
        network.load_state_dict(fitting(tensors, network.state_dict()), assign=True)
        return cls(network)
