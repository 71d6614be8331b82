"""The policy `chunk_diffusion`: chunks are denoised, given the history."""

from pydantic import Field

from t2l.policies.chunk_policy import ChunkPolicy, ChunkSettings, ChunkSizes, Size, Widths
from t2l.typed import Integer


class Settings(ChunkSettings):
    """Of training, and of acting."""

    hidden: Widths = Field(
        [256, 256, 256], description="widths of the hidden layers of the denoiser"
    )
    denoising_steps: Integer = Field(
        10, ge=1, le=1_000, description="steps from noise to a chunk: a policy acts so much slower"
    )


class Sizes(ChunkSizes):
    """Of the network."""

    hidden: list[Size]
    denoising_steps: Size


class ChunkDiffusion(ChunkPolicy):
    """Acts by a sample of what was demonstrated. The same calls give the same samples."""

    name = "chunk_diffusion"
    settings, sizes = Settings, Sizes
    network_class = "t2l.policies.chunk_diffusion_network:ChunkDiffusionNetwork"
