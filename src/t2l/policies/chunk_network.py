"""Networks from an observation history to an action chunk; both in physical units outside."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from t2l.policies.chunk_policy import FEATURES, ChunkSettings, ChunkSizes
from t2l.policies.picture_encoder import PictureEncoder, shifted


class ChunkNetwork(nn.Module, ABC):
    """What a `ChunkPolicy` trains and acts by; a `t2l.policies.training.Network`.

    Buffers hold the mean and scale of observations and actions, so that a policy carries its own
    normalisation. Histories are (n, history, observation_size), chunks (n, chunk, action_size);
    pictures (n, ncamera, height, width, 3) uint8, for a network that sees by cameras, are of the
    latest observation.

    Attributes:
        sizes: what it takes to make it again, but for the weights.
    """

    def __init__(self, sizes: ChunkSizes, settings: ChunkSettings | None = None):
        """Weights are drawn by torch's generator.

        Args:
            settings: of training; None for a network that only acts.
        """
        super().__init__()
        self.sizes = sizes
        self.observation_noise = settings.observation_noise if settings else 0.0
        self.picture_shift_px = settings.picture_shift_px if settings and sizes.cameras else 0
        self.make(sizes, settings)
        if sizes.cameras:
            self.pictures = PictureEncoder(sizes.cameras)
        for name, size in (("observation", sizes.observation_size), ("action", sizes.action_size)):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_scale", torch.ones(size))

    @abstractmethod
    def make(self, sizes: ChunkSizes, settings: ChunkSettings | None) -> None:
        """Add what has weights, and what the loss takes from the settings."""

    @property
    def history_size(self) -> int:
        """Numbers in a history."""
        return self.sizes.history * self.sizes.observation_size

    @property
    def condition_size(self) -> int:
        """Numbers that a chunk is to follow from: those of a history, and of pictures."""
        return self.history_size + self.sizes.cameras * FEATURES

    @property
    def chunk_size(self) -> int:
        """Numbers in a chunk."""
        return self.sizes.chunk * self.sizes.action_size

    def normalise_by(self, observations: Tensor, actions: Tensor) -> None:
        """Take mean and scale from data (n, size); an element that never changes keeps scale 1."""
        for name, values in (("observation", observations), ("action", actions)):
            scale = values.std(dim=0)
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(torch.where(scale > 1e-4, scale, 1.0))

    def draws(self, n: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """Of n windows: noise on the history, shifts of pictures, and what else `error` takes."""
        noise, most = standard_normal(n, self.history_size, generator), self.picture_shift_px
        if not most:
            return (noise,)
        # every camera its own, or their views would still agree on where a block is
        shape, device = (n, self.sizes.cameras, 2), generator.device
        return noise, torch.randint(-most, most + 1, shape, generator=generator, device=device)

    def loss(
        self,
        history: Tensor,
        chunk: Tensor,
        history_noise: Tensor,
        *draws: Tensor,
        pictures: Tensor | None = None,
    ) -> tuple[Tensor, Tensor]:
        """What is minimised, and the part of it that is an error: two scalars.

        Args:
            history_noise, draws: of `draws`.
        """
        if self.picture_shift_px:
            shift, *draws = draws
            pictures = shifted(pictures, shift)
        condition = self.condition(history, pictures, self.observation_noise * history_noise)
        return self.error(condition, self.normalised(chunk), *draws)

    @abstractmethod
    def error(self, condition: Tensor, target: Tensor, *draws: Tensor) -> tuple[Tensor, Tensor]:
        """`loss` of conditions (n, condition_size) and normalised chunks (n, chunk_size)."""

    @abstractmethod
    def answer(self, condition: Tensor) -> Tensor:
        """Normalised chunks (n, chunk_size), for conditions as in `error`."""

    def prediction_error(
        self, history: Tensor, chunk: Tensor, pictures: Tensor | None = None
    ) -> Tensor:
        """Mean squared error of normalised actions when acting."""
        answer = self.answer(self.condition(history, pictures))
        return (answer - self.normalised(chunk)).square().mean()

    def forward(self, history: Tensor, pictures: Tensor | None = None) -> Tensor:
        """The action chunk for a history."""
        chunk = self.answer(self.condition(history, pictures)).unflatten(1, (self.sizes.chunk, -1))
        return chunk * self.action_scale + self.action_mean

    def condition(
        self, history: Tensor, pictures: Tensor | None = None, noise: Tensor | None = None
    ) -> Tensor:
        """(n, condition_size): normalised histories with `noise`, and what pictures become."""
        # a state far outside the demonstrations must not blow the network up
        row = ((history - self.observation_mean) / self.observation_scale).clamp(-10, 10).flatten(1)
        if noise is not None:
            row = row + noise
        return row if pictures is None else torch.cat([row, self.pictures(pictures)], dim=1)

    def normalised(self, chunk: Tensor) -> Tensor:
        """Normalised chunks (n, chunk_size)."""
        return ((chunk - self.action_mean) / self.action_scale).flatten(1)


def standard_normal(n: int, size: int, generator: torch.Generator) -> Tensor:
    """(n, size), on the generator's device."""
    return torch.randn(n, size, generator=generator, device=generator.device)


def perceptron(inputs: int, hidden: Sequence[int], outputs: int) -> nn.Sequential:
    """Layers of ReLU units, and a linear one."""
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))
