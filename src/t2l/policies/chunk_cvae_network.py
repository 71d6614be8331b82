"""The network of `chunk_cvae`: a conditional variational autoencoder of multilayer perceptrons.

Sohn, Lee and Yan (2015), eq. 5, with the observation history as condition: the encoder infers a
latent from a demonstrated chunk, the decoder reproduces the chunk from history and latent, and the
latent's prior is a standard normal whose mean, zero, is decoded when acting (as in ACT, Zhao et
al. 2023).
"""

from collections.abc import Sequence

import torch
from torch import nn

from t2l.policies.chunk_cvae import Sizes


class ChunkCVAENetwork(nn.Module):
    """Observation history in, action chunk out; both in physical units outside.

    Buffers hold the mean and scale of observations and actions, so that a policy carries its own
    normalisation.
    """

    def __init__(self, sizes: Sizes, kl_weight: float = 0.0, observation_noise: float = 0.0):
        """Weights are drawn by torch's generator.

        Args:
            kl_weight: weight, in the loss, of the divergence from the prior, per latent element.
            observation_noise: standard deviation of noise on normalised observations, in the loss.
        """
        super().__init__()
        self.kl_weight, self.observation_noise = kl_weight, observation_noise
        self.sizes = s = sizes
        history_size, chunk_size = s.history * s.observation_size, s.chunk * s.action_size
        self.encoder = _mlp(history_size + chunk_size, s.hidden, 2 * s.latent)
        self.decoder = _mlp(history_size + s.latent, s.hidden, chunk_size)
        for name, size in (("observation", s.observation_size), ("action", s.action_size)):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_scale", torch.ones(size))

    def normalise_by(self, observations: torch.Tensor, actions: torch.Tensor) -> None:
        """Take mean and scale from data (n, size); an element that never changes keeps scale 1."""
        for name, values in (("observation", observations), ("action", actions)):
            scale = values.std(dim=0)
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(torch.where(scale > 1e-4, scale, 1.0))

    def draws(self, n: int, generator: torch.Generator) -> tuple[torch.Tensor, torch.Tensor]:
        """Standard normal numbers of n windows: on the history, on the latent."""
        device = generator.device
        return (
            torch.randn(
                n,
                self.sizes.history * self.sizes.observation_size,
                generator=generator,
                device=device,
            ),
            torch.randn(n, self.sizes.latent, generator=generator, device=device),
        )

    def loss(
        self,
        history: torch.Tensor,
        chunk: torch.Tensor,
        history_noise: torch.Tensor,
        latent_noise: torch.Tensor,
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Negative evidence bound up to constants, and its reconstruction part.

        Args:
            history: (n, history, observation_size).
            chunk: (n, chunk, action_size).
            history_noise, latent_noise: of `draws`.

        Returns:
            Two scalars: the training loss and the mean squared error of normalised actions.
        """
        condition = self._condition(history) + self.observation_noise * history_noise
        target = self._normalised_chunk(chunk)
        mean, log_variance = self.encoder(torch.cat([condition, target], dim=1)).chunk(2, dim=1)
        latent = mean + latent_noise * (0.5 * log_variance).exp()
        reconstruction = (self._decode(condition, latent) - target).square().mean()
        kl = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance).mean()
        return reconstruction + self.kl_weight * kl, reconstruction

    def prediction_error(self, history: torch.Tensor, chunk: torch.Tensor) -> torch.Tensor:
        """Mean squared error of normalised actions when acting, i.e. with a zero latent."""
        condition = self._condition(history)
        latent = condition.new_zeros(len(condition), self.sizes.latent)
        return (self._decode(condition, latent) - self._normalised_chunk(chunk)).square().mean()

    def forward(self, history: torch.Tensor) -> torch.Tensor:
        """The action chunk (n, chunk, action_size) for a history (n, history, observation_size)."""
        condition = self._condition(history)
        latent = condition.new_zeros(len(condition), self.sizes.latent)
        chunk = self._decode(condition, latent).unflatten(1, (self.sizes.chunk, -1))
        return chunk * self.action_scale + self.action_mean

    def _condition(self, history: torch.Tensor) -> torch.Tensor:
        # a state far outside the demonstrations must not blow the network up
        return (
            ((history - self.observation_mean) / self.observation_scale).clamp(-10, 10).flatten(1)
        )

    def _normalised_chunk(self, chunk: torch.Tensor) -> torch.Tensor:
        return ((chunk - self.action_mean) / self.action_scale).flatten(1)

    def _decode(self, condition: torch.Tensor, latent: torch.Tensor) -> torch.Tensor:
        return self.decoder(torch.cat([condition, latent], dim=1))


def _mlp(inputs: int, hidden: Sequence[int], outputs: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))
