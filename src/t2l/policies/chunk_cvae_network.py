"""The network of `chunk_cvae`: a conditional variational autoencoder of multilayer perceptrons.

Sohn, Lee and Yan (2015), eq. 5, with the observation history as condition: the encoder infers a
latent from a demonstrated chunk, the decoder reproduces the chunk from history and latent, and the
latent's prior is a standard normal whose mean, zero, is decoded when acting (as in ACT, Zhao et
al. 2023).
"""

import torch
from torch import Tensor, nn

from t2l.policies.chunk_cvae import LatentSettings, Sizes
from t2l.policies.chunk_network import ChunkNetwork, perceptron, standard_normal


class ChunkCVAENetwork(ChunkNetwork):
    """An encoder of chunks and a decoder of latents, both of them told the history."""

    def make(self, sizes: Sizes, settings: LatentSettings | None) -> None:
        """See `ChunkNetwork.make`."""
        self.kl_weight = settings.kl_weight if settings else 0.0
        self.encoder, self.decoder = self.coders(sizes)

    def coders(self, sizes: Sizes) -> tuple[nn.Module, nn.Module]:
        """From condition and chunk to mean and log variance of a latent; from condition and latent.

        Both take one row of numbers each, the condition's first.
        """
        return (
            perceptron(self.condition_size + self.chunk_size, sizes.hidden, 2 * sizes.latent),
            perceptron(self.condition_size + sizes.latent, sizes.hidden, self.chunk_size),
        )

    def draws(self, n: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """As `ChunkNetwork.draws`, and on the latent."""
        return *super().draws(n, generator), standard_normal(n, self.sizes.latent, generator)

    def error(
        self, condition: Tensor, target: Tensor, latent_noise: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Negative evidence bound up to constants, and its reconstruction part."""
        mean, log_variance = self.encoder(torch.cat([condition, target], dim=1)).chunk(2, dim=1)
        latent = mean + latent_noise * (0.5 * log_variance).exp()
        reconstruction = (self._decode(condition, latent) - target).square().mean()
        kl = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance).mean()
        return reconstruction + self.kl_weight * kl, reconstruction

    def answer(self, condition: Tensor) -> Tensor:
        """What the mean of the prior stands for."""
        return self._decode(condition, condition.new_zeros(len(condition), self.sizes.latent))

    def _decode(self, condition: Tensor, latent: Tensor) -> Tensor:
        return self.decoder(torch.cat([condition, latent], dim=1))
