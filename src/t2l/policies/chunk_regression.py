"""The policy `chunk_regression`: one multilayer perceptron from history to chunk."""

from pydantic import Field

from t2l.policies.chunk_policy import ChunkPolicy, ChunkSettings, ChunkSizes, Size, Widths


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
    network_class = "t2l.policies.chunk_regression_network:ChunkRegressionNetwork"
