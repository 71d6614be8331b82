"""The network of `chunk_regression`."""

from torch import Tensor

from t2l.policies.chunk_network import ChunkNetwork, perceptron
from t2l.policies.chunk_regression import Settings, Sizes


class ChunkRegressionNetwork(ChunkNetwork):
    """Least squares."""

    def make(self, sizes: Sizes, settings: Settings | None) -> None:
        """See `ChunkNetwork.make`."""
        self.layers = perceptron(self.condition_size, sizes.hidden, self.chunk_size)

    def error(self, condition: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        """The mean squared error of actions, twice."""
        squared = (self.answer(condition) - target).square().mean()
        return squared, squared

    def answer(self, condition: Tensor) -> Tensor:
        """See `ChunkNetwork.answer`."""
        return self.layers(condition)
