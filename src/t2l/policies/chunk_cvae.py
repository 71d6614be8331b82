"""The policy `chunk_cvae`: a conditional variational autoencoder of action chunks.

Its network is `t2l.policies.chunk_cvae_network`; only what needs it loads torch.
"""

from pydantic import Field

from t2l.policies.chunk_policy import ChunkPolicy, ChunkSettings, ChunkSizes, Size, Widths
from t2l.typed import Integer, Number


class LatentSettings(ChunkSettings):
    """Of training an autoencoder."""

    latent: Integer = Field(8, ge=1, le=1_000, description="size of the latent")
    kl_weight: Number = Field(
        0.01, ge=0, description="weight of the latent's divergence from its prior"
    )


class Settings(LatentSettings):
    """Of training."""

    hidden: Widths = Field(
        [256, 256, 256], description="widths of the hidden layers of encoder and decoder"
    )


class Sizes(ChunkSizes):
    """Of the network."""

    latent: Size
    hidden: list[Size]


class ChunkCVAE(ChunkPolicy):
    """Acts by the mean of the latent's prior."""

    name = "chunk_cvae"
    settings, sizes = Settings, Sizes
    network_class = "t2l.policies.chunk_cvae_network:ChunkCVAENetwork"
