"""Functions of tensors whose kernels a GPU is given at once, as a CUDA graph.

Small networks keep a GPU waiting for the next launch; a graph is one launch.
"""

from collections.abc import Callable

import torch
from torch import Tensor

# calls before a capture, in which libraries are set up; torch's own number
WARM_UPS = 3


class Captured:
    """A function that computes the same on the same shapes; on a processor it is merely called.

    It may read other tensors, which may change in place. What it returns is overwritten by the next
    call.

    Args:
        function: of tensors, by position or by name, to a tuple of tensors. It draws no random
            numbers, and nothing on the processor depends on what it computes.
    """

    def __init__(self, function: Callable[..., tuple[Tensor, ...]]):
        self._function = function
        self._graph: torch.cuda.CUDAGraph | None = None

    def __call__(self, *arguments: Tensor, **named: Tensor) -> tuple[Tensor, ...]:
        """What the function returns."""
        if not arguments[0].is_cuda:
            return self._function(*arguments, **named)
        if self._graph is None:
            self._capture(arguments, named)
        for own, given in zip(self._own, (*arguments, *named.values()), strict=True):
            # `copy_` would stretch one of another shape
            assert own.shape == given.shape, f"{tuple(given.shape)} after {tuple(own.shape)}"
            own.copy_(given)
        self._graph.replay()
        return self._results

    def _capture(self, arguments: tuple[Tensor, ...], named: dict[str, Tensor]) -> None:
        own = [argument.clone() for argument in arguments]
        own_named = {name: argument.clone() for name, argument in named.items()}
        self._own = [*own, *own_named.values()]
        # torch refuses to capture what a stream has not done before
        side, current = torch.cuda.Stream(), torch.cuda.current_stream()
        side.wait_stream(current)
        with torch.cuda.stream(side):
            for _ in range(WARM_UPS):
                self._function(*own, **own_named)
        current.wait_stream(side)
        self._graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(self._graph):
            self._results = self._function(*own, **own_named)
