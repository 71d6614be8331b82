"""The policy `chunk_regression`: one multilayer perceptron from history to chunk."""

from typing import TYPE_CHECKING

from pydantic import Field

from t2l.policies.chunk_policy import ChunkPolicy, ChunkSettings, ChunkSizes, Size, Widths

if TYPE_CHECKING:
    from t2l.policies.chunk_network import ChunkNetwork


class Settings(ChunkSettings):
    """Of training."""

    hidden: Widths = Field([256, 256, 256], description="widths of the hidden layers")


class Sizes(ChunkSizes):
    """Of the network."""

    hidden: list[Size]


class ChunkRegression(ChunkPolicy):
    """Acts by the mean of what was demonstrated."""

    name = "chunk_regression"
    settings, sizes = Settings, Sizes

    @classmethod
    def network_class(cls) -> "type[ChunkNetwork]":
        """See `ChunkPolicy.network_class`."""
        from t2l.policies.chunk_regression_network import ChunkRegressionNetwork

        return ChunkRegressionNetwork
