"""The network of `chunk_diffusion`: a perceptron that tells a chunk from a noisy one.

A chunk x with noise ε is √ᾱ x + √(1 − ᾱ) ε (Ho et al. 2020, eq. 4), ᾱ = cos²(π t / 2) at time t
(Nichol and Dhariwal 2021, eq. 17, without offset). The network tells x itself, which is well
conditioned where nearly all is noise. It acts by the deterministic steps of DDIM (Song et al.
2021, eq. 12, σ = 0).
"""

import math
from itertools import pairwise

import torch
from torch import Tensor

from t2l.policies.chunk_diffusion import Settings, Sizes
from t2l.policies.chunk_network import ChunkNetwork, perceptron, standard_normal

OCTAVES = 6  # of waves that tell the network the time: the shortest has a period of an eighth


class ChunkDiffusionNetwork(ChunkNetwork):
    """Denoises chunks."""

    def make(self, sizes: Sizes, settings: Settings | None) -> None:
        """See `ChunkNetwork.make`."""
        inputs = self.condition_size + self.chunk_size + 2 * OCTAVES
        self.denoiser = perceptron(inputs, sizes.hidden, self.chunk_size)
        self._generator = torch.Generator().manual_seed(0)

    def draws(self, n: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """As `ChunkNetwork.draws`, noise on the chunk, and times (n, 1) from 0 to 1."""
        return (
            *super().draws(n, generator),
            standard_normal(n, self.chunk_size, generator),
            torch.rand(n, 1, generator=generator, device=generator.device),
        )

    def error(
        self, condition: Tensor, target: Tensor, noise: Tensor, time: Tensor
    ) -> tuple[Tensor, Tensor]:
        """The mean squared error of denoised chunks, twice."""
        signal, rest = _shares(time)
        squared = (
            self._denoised(condition, signal * target + rest * noise, time) - target
        ).square()
        return squared.mean(), squared.mean()

    def answer(self, condition: Tensor) -> Tensor:
        """A sample."""
        # drawn on the processor, so that it is the same on every device
        noise = standard_normal(len(condition), self.chunk_size, self._generator)
        return self.sampled(condition, noise.to(condition.device))

    def sampled(self, condition: Tensor, noise: Tensor) -> Tensor:
        """The chunks (n, chunk_size) that some noise stands for."""
        steps = self.sizes.denoising_steps
        times = torch.linspace(1, 0, steps + 1, device=noise.device)
        noisy = noise
        for now, then in pairwise(times):
            chunk = self._denoised(condition, noisy, now.expand(len(noisy), 1))
            signal, rest = _shares(now)
            left = (noisy - signal * chunk) / rest
            signal, rest = _shares(then)
            noisy = signal * chunk + rest * left
        return chunk

    def prediction_error(
        self, history: Tensor, chunk: Tensor, pictures: Tensor | None = None
    ) -> Tensor:
        """See `ChunkNetwork.prediction_error`; of the same noise at every call."""
        generator = torch.Generator().manual_seed(0)
        noise = standard_normal(len(history), self.chunk_size, generator).to(history.device)
        answer = self.sampled(self.condition(history, pictures), noise)
        return (answer - self.normalised(chunk)).square().mean()

    def _denoised(self, condition: Tensor, noisy: Tensor, time: Tensor) -> Tensor:
        phase = math.pi / 2 * time * 2.0 ** torch.arange(OCTAVES, device=time.device)
        return self.denoiser(torch.cat([condition, noisy, phase.sin(), phase.cos()], dim=1))


def _shares(time: Tensor) -> tuple[Tensor, Tensor]:
    """Of chunk and of noise at a time: √ᾱ and √(1 − ᾱ)."""
    angle = math.pi / 2 * time
    return angle.cos(), angle.sin()
