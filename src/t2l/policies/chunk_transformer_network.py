"""The network of `chunk_transformer`.

Every observation of the history is a token, every action of a chunk too, as in ACT (Zhao et al.
2023), and all tokens attend to all. Without dropout, so that a training is its seed's alone.
"""

import torch
from torch import Tensor, nn
from torch.nn.attention import SDPBackend, sdpa_kernel

from t2l.policies.chunk_cvae_network import ChunkCVAENetwork
from t2l.policies.chunk_transformer import Sizes

FEED_FORWARD = 4  # times the width of a token, as Vaswani et al. (2017) have it


class ChunkTransformerNetwork(ChunkCVAENetwork):
    """`ChunkCVAENetwork` with other coders."""

    def coders(self, sizes: Sizes) -> tuple[nn.Module, nn.Module]:
        """See `ChunkCVAENetwork.coders`."""
        return _Encoder(sizes), _Decoder(sizes)


class _Encoder(nn.Module):
    """The answer is read from a token of its own, the last."""

    def __init__(self, sizes: Sizes):
        super().__init__()
        self.sizes = sizes
        self.observed = nn.Linear(sizes.observation_size, sizes.width)
        self.demonstrated = nn.Linear(sizes.action_size, sizes.width)
        self.position = _positions(sizes.history + sizes.chunk + 1, sizes.width)
        self.trunk = _trunk(sizes)
        self.latent = nn.Linear(sizes.width, 2 * sizes.latent)

    def forward(self, row: Tensor) -> Tensor:
        s = self.sizes
        history, chunk = row.split([s.history * s.observation_size, s.chunk * s.action_size], dim=1)
        tokens = torch.cat(
            [
                self.observed(history.unflatten(1, (s.history, -1))),
                self.demonstrated(chunk.unflatten(1, (s.chunk, -1))),
                row.new_zeros(len(row), 1, s.width),
            ],
            dim=1,
        )
        return self.latent(self.trunk(tokens + self.position)[:, -1])


class _Decoder(nn.Module):
    """Each action is read from a token of its own, after those of the history and the latent."""

    def __init__(self, sizes: Sizes):
        super().__init__()
        self.sizes = sizes
        self.observed = nn.Linear(sizes.observation_size, sizes.width)
        self.latent = nn.Linear(sizes.latent, sizes.width)
        self.position = _positions(sizes.history + 1 + sizes.chunk, sizes.width)
        self.trunk = _trunk(sizes)
        self.action = nn.Linear(sizes.width, sizes.action_size)

    def forward(self, row: Tensor) -> Tensor:
        s = self.sizes
        history, latent = row.split([s.history * s.observation_size, s.latent], dim=1)
        tokens = torch.cat(
            [
                self.observed(history.unflatten(1, (s.history, -1))),
                self.latent(latent)[:, None],
                row.new_zeros(len(row), s.chunk, s.width),
            ],
            dim=1,
        )
        return self.action(self.trunk(tokens + self.position)[:, -s.chunk :]).flatten(1)


def _positions(tokens: int, width: int) -> nn.Parameter:
    # small, as the weights of the layers are
    return nn.Parameter(0.02 * torch.randn(tokens, width))


class _Trunk(nn.TransformerEncoder):
    def forward(self, tokens: Tensor) -> Tensor:
        # the only kernel that networks side by side share; with so few tokens none is faster
        with sdpa_kernel(SDPBackend.MATH):
            return super().forward(tokens)


def _trunk(sizes: Sizes) -> _Trunk:
    layer = nn.TransformerEncoderLayer(
        sizes.width, sizes.heads, FEED_FORWARD * sizes.width, dropout=0.0, activation="gelu",
        batch_first=True, norm_first=True,
    )  # fmt: skip
    return _Trunk(layer, sizes.layers, norm=nn.LayerNorm(sizes.width), enable_nested_tensor=False)
