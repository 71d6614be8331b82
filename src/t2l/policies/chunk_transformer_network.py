"""The network of `chunk_transformer`.

Every observation of the history is a token, every picture and every action of a chunk too, as in
ACT (Zhao et al. 2023), and all tokens attend to all; the latent is one token. Without dropout, so
that a training is its seed's alone.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn.attention import SDPBackend, sdpa_kernel

from t2l.policies.chunk_cvae_network import ChunkCVAENetwork
from t2l.policies.chunk_policy import FEATURES
from t2l.policies.chunk_transformer import Sizes, Trunk

FEED_FORWARD = 4  # times the width of a token, as Vaswani et al. (2017) have it


class ChunkTransformerNetwork(ChunkCVAENetwork):
    """`ChunkCVAENetwork` with other coders."""

    def coders(self, sizes: Sizes) -> tuple[nn.Module, nn.Module]:
        """See `ChunkCVAENetwork.coders`."""
        condition = [(sizes.history, sizes.observation_size)]
        if sizes.cameras:
            condition.append((sizes.cameras, FEATURES))
        chunk, latent = (sizes.chunk, sizes.action_size), (1, sizes.latent)
        return (
            _Coder(sizes, [*condition, chunk], (1, 2 * sizes.latent)),
            _Coder(sizes, [*condition, latent], chunk),
        )


class _Coder(nn.Module):
    """Tokens of what is known, then those that the answer is read from.

    Args:
        known: (tokens, numbers in each) of each part of a row.
        asked: the same of the answer.
    """

    def __init__(self, sizes: Trunk, known: Sequence[tuple[int, int]], asked: tuple[int, int]):
        super().__init__()
        self.known, self.asked, self.width = known, asked[0], sizes.width
        self.embeddings = nn.ModuleList(nn.Linear(numbers, sizes.width) for _, numbers in known)
        tokens = sum(count for count, _ in known) + asked[0]
        # small, as the weights of the layers are
        self.position = nn.Parameter(0.02 * torch.randn(tokens, sizes.width))
        self.trunk = _trunk(sizes)
        self.answer = nn.Linear(sizes.width, asked[1])

    def forward(self, row: Tensor) -> Tensor:
        parts = row.split([count * numbers for count, numbers in self.known], dim=1)
        tokens = [
            embed(part.unflatten(1, (count, numbers)))
            for embed, part, (count, numbers) in zip(
                self.embeddings, parts, self.known, strict=True
            )
        ]
        tokens.append(row.new_zeros(len(row), self.asked, self.width))
        seen = self.trunk(torch.cat(tokens, dim=1) + self.position)
        return self.answer(seen[:, -self.asked :]).flatten(1)


class _Trunk(nn.TransformerEncoder):
    def forward(self, tokens: Tensor) -> Tensor:
        # the only kernel that networks side by side share; with so few tokens none is faster
        with sdpa_kernel(SDPBackend.MATH):
            return super().forward(tokens)


def _trunk(sizes: Trunk) -> _Trunk:
    layer = nn.TransformerEncoderLayer(
        sizes.width, sizes.heads, FEED_FORWARD * sizes.width, dropout=0.0, activation="gelu",
        batch_first=True, norm_first=True,
    )  # fmt: skip
    return _Trunk(layer, sizes.layers, norm=nn.LayerNorm(sizes.width), enable_nested_tensor=False)
