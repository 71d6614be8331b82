"""Networks of one shape side by side: their parameters as rows of one matrix."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.func import functional_call

# of Adam, as torch has them
BETAS, EPSILON = (0.9, 0.999), 1e-8


class Stack:
    """The parameters of many networks, a row each.

    Attributes:
        rows: (n, nparameter); a leaf that gradients are taken for.
    """

    def __init__(self, networks: Sequence[torch.nn.Module], device: torch.device):
        """Take the parameters of networks of the same shape."""
        self._network = networks[0].to(device)
        parameters = [dict(network.named_parameters()) for network in networks]
        self._shapes = {name: value.shape for name, value in parameters[0].items()}
        flat = [
            torch.cat([value.detach().flatten() for value in own.values()]) for own in parameters
        ]
        self.rows = torch.stack([row.to(device) for row in flat]).requires_grad_()

    def named(self, row: Tensor) -> dict[str, Tensor]:
        """The parameters of a network by name, out of its row."""
        parts = row.split([shape.numel() for shape in self._shapes.values()])
        return {
            name: part.view(shape)
            for (name, shape), part in zip(self._shapes.items(), parts, strict=True)
        }

    def of_row(self, row: Tensor, *arguments: Tensor):
        """What the network of a row gives; for `torch.vmap`."""
        return functional_call(self._network, self.named(row), arguments)

    def __call__(self, *arguments: Tensor):
        """What every network gives for arguments (n, …)."""
        return torch.vmap(self.of_row)(self.rows, *arguments)


class Adam:
    """Adam (Kingma and Ba, 2015, algorithm 1) where each row has a learning rate of its own.

    torch's has one rate for all that it optimises.
    """

    def __init__(self, rows: Tensor):
        self._rows, self._steps = rows, 0
        self._mean, self._square = torch.zeros_like(rows), torch.zeros_like(rows)

    def state(self) -> dict[str, Any]:
        """Of rows and their moments, for `restore`."""
        return {
            "rows": self._rows.detach(), "mean": self._mean, "square": self._square,
            "steps": self._steps,
        }  # fmt: skip

    @torch.no_grad()
    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`, in place: whoever holds the rows sees it."""
        for name in ("rows", "mean", "square"):
            getattr(self, f"_{name}").copy_(state[name])
        self._steps = state["steps"]

    @torch.no_grad()
    def step(self, gradient: Tensor, rate: Tensor) -> None:
        """Move the rows; gradient (n, nparameter), rate (n,)."""
        self._steps += 1
        (first, second), n = BETAS, self._steps
        self._mean.lerp_(gradient, 1 - first)
        self._square.lerp_(gradient**2, 1 - second)
        root = (self._square / (1 - second**n)).sqrt_().add_(EPSILON)
        self._rows -= rate[:, None] * self._mean / (1 - first**n) / root
