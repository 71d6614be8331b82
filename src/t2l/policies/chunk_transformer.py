"""The policy `chunk_transformer`: `chunk_cvae` with Transformers in place of its perceptrons."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from t2l.policies.chunk_cvae import LatentSettings
from t2l.policies.chunk_policy import ChunkPolicy, ChunkSizes, Size
from t2l.typed import Integer, Typed


class Trunk(Typed):
    """Of encoder and decoder alike."""

    layers: Annotated[Integer, Field(ge=1, le=50)] = Field(
        4, description="layers of the encoder, and of the decoder"
    )
    width: Annotated[Integer, Field(ge=1, le=4_096)] = Field(
        128, description="numbers in a token, a multiple of `heads`"
    )
    heads: Annotated[Integer, Field(ge=1, le=64)] = Field(4, description="heads of attention")

    @model_validator(mode="after")
    def _divides(self) -> Self:
        if self.width % self.heads:
            raise ValueError("a width that is a multiple of heads")
        return self


class Settings(Trunk, LatentSettings):
    """Of training."""


class Sizes(Trunk, ChunkSizes):
    """Of the network."""

    latent: Size


class ChunkTransformer(ChunkPolicy):
    """Acts by the mean of the latent's prior."""

    name = "chunk_transformer"
    settings, sizes = Settings, Sizes
    network_class = "t2l.policies.chunk_transformer_network:ChunkTransformerNetwork"
