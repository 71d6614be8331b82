"""Training of torch networks on windows of episodes: AdamW with a one-cycle schedule.

Networks of one shape are trained side by side, each on data and with random numbers of its own, as
one stack of parameters (`torch.func`). One alone is a stack of one. A processor gains nothing by
more of them; a GPU trains dozens in the time of one.
"""

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
import pandas as pd
import torch
from torch import Tensor
from torch.func import functional_call, stack_module_state, vmap

from t2l.policies.captured import Captured
from t2l.policies.policy import Episode
from t2l.policies.training_settings import TrainingSettings
from t2l.policies.validation import AT_ONCE, PICTURED_AT_ONCE
from t2l.policies.windows import pictured, windows

log = logging.getLogger(__name__)

# largest norm of a gradient, a usual bound for networks of this size
GRADIENT_NORM = 1.0


class Network(Protocol):
    """What can be trained, and judged on windows. It is a `torch.nn.Module` too."""

    def draws(self, n: int, generator: torch.Generator) -> tuple[Tensor, ...]:
        """The random numbers that the loss of n windows takes."""

    def loss(
        self, history: Tensor, chunk: Tensor, *draws: Tensor, **pictures: Tensor
    ) -> tuple[Tensor, Tensor]:
        """What is minimised, and the part of it that is the actions' error: two scalars.

        Args:
            pictures: `pictures`, where the data have some.
        """

    def prediction_error(self, history: Tensor, chunk: Tensor, **pictures: Tensor) -> Tensor:
        """Mean squared error of normalised actions when acting, a scalar."""


class Data:
    """Windows of some episodes on a device, gathered by index so that none is stored twice.

    Args:
        store: on the device, of the episodes' pictures, if they have some.
    """

    def __init__(
        self,
        episodes: Sequence[Episode],
        settings: TrainingSettings,
        device: torch.device,
        store: Tensor | None = None,
    ):
        arrays = windows(episodes, settings.history, settings.chunk)
        self.observation, self.action = (
            torch.as_tensor(a, dtype=torch.float32, device=device) for a in arrays[:2]
        )
        self._past, self._future = (torch.as_tensor(a, device=device) for a in arrays[2:])
        self._store = store
        if store is not None:
            self._frames = torch.as_tensor(pictured(episodes).frames, device=device)

    def __len__(self) -> int:
        return len(self._past)

    def __getitem__(self, index: Tensor) -> tuple[Tensor, Tensor]:
        """Histories (…, history, nobs) and chunks (…, chunk, nact) of steps (…)."""
        return self.observation[self._past[index]], self.action[self._future[index]]

    def pictures(self, index: Tensor) -> dict[str, Tensor]:
        """Nothing, or `pictures` (…, ncamera, height, width, 3) of steps (…)."""
        return {} if self._store is None else {"pictures": self._store[self._frames[index]]}

    @property
    def at_once(self) -> int:
        """Steps that are judged at once."""
        return AT_ONCE if self._store is None else PICTURED_AT_ONCE


@contextmanager
def reproducible(threads: int) -> Iterator[torch.device]:
    """Make what torch computes within depend on seeds alone; gives the device to use.

    That is the GPU if there is one, whose matrix products round what they multiply to 10 bits.
    Generators, threads and settings are as before afterwards.
    """
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    before = torch.get_num_threads()
    deterministic = torch.are_deterministic_algorithms_enabled()
    warning = torch.is_deterministic_algorithms_warn_only_enabled()
    rounded = torch.backends.cuda.matmul.allow_tf32
    with torch.random.fork_rng([device] if device.type == "cuda" else []):
        torch.set_num_threads(threads)
        torch.use_deterministic_algorithms(True, warn_only=True)
        # else these products take most of the time there
        torch.backends.cuda.matmul.allow_tf32 = True
        try:
            yield device
        finally:
            torch.set_num_threads(before)
            torch.use_deterministic_algorithms(deterministic, warn_only=warning)
            torch.backends.cuda.matmul.allow_tf32 = rounded


class _Loss(torch.nn.Module):
    """`Network.loss` as what a module computes, which is what `functional_call` calls."""

    def __init__(self, network: torch.nn.Module):
        super().__init__()
        self.network = network

    def forward(self, *arguments: Tensor, **pictures: Tensor) -> tuple[Tensor, Tensor]:
        return self.network.loss(*arguments, **pictures)


def train[N: torch.nn.Module](
    networks: Sequence[N],
    training: Data,
    parts: Sequence[range],
    validation: Sequence[Data],
    settings: TrainingSettings,
    seeds: Sequence[int],
) -> list[pd.DataFrame]:
    """Minimise each network's loss on its own data, in place.

    Every batch is full: where an order of windows ends before its epoch does, it begins again.

    Args:
        networks: each a `Network` too, of the same shape.
        training: of all networks.
        parts: each network's windows of `training`.
        validation: of each network.
        seeds: of each network's order of windows and of its draws.

    Returns:
        For each network one row an epoch: epoch, training_loss, reconstruction, validation_loss.
    """
    device, size = training.observation.device, settings.batch_size
    batches = max(-(-len(part) // size) for part in parts)
    generators = [torch.Generator(device).manual_seed(seed) for seed in seeds]
    templates = [_Loss(network) for network in networks]
    stacked, buffers = stack_module_state(templates)
    parameters = list(stacked.values())
    optimiser = torch.optim.AdamW(
        parameters, lr=settings.learning_rate, weight_decay=settings.weight_decay, fused=True
    )
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, settings.learning_rate, total_steps=settings.epochs * batches, pct_start=0.1
    )
    losses = _side_by_side(_stateless(templates[0]), len(networks))

    def gradients_of(*arguments: Tensor, **pictures: Tensor) -> tuple[Tensor, ...]:
        minimised, reconstruction = losses(stacked, buffers, pictures, *arguments)
        gradients = torch.autograd.grad(minimised.sum(), parameters)
        return torch.stack([minimised, reconstruction]).detach(), *_clipped(gradients)

    step = Captured(gradients_of)
    rows, start = [[] for _ in networks], time.monotonic()
    for epoch in range(1, settings.epochs + 1):
        totals = torch.zeros(2, len(networks), device=device)
        orders = [_order(*pair, batches * size) for pair in zip(parts, generators, strict=True)]
        for index in torch.stack(orders).split(size, dim=1):
            draws = [n.draws(size, g) for n, g in zip(networks, generators, strict=True)]
            arguments = [*training[index], *map(torch.stack, zip(*draws, strict=True))]
            found, *gradients = step(*arguments, **training.pictures(index))
            for parameter, gradient in zip(parameters, gradients, strict=True):
                parameter.grad = gradient
            optimiser.step()
            schedule.step()
            totals += found
        _unstack(stacked, templates)
        for i, trained in enumerate((totals / batches).T.tolist()):
            rows[i].append((epoch, *trained, _validation_loss(networks[i], validation[i])))
        elapsed = time.monotonic() - start
        log.info(
            "epoch %d of %d: training loss %.5f, validation loss %.5f, %.0f s left",
            *(epoch, settings.epochs, *np.mean([row[-1] for row in rows], axis=0)[[1, 3]]),
            elapsed / epoch * (settings.epochs - epoch),
        )
    columns = ["epoch", "training_loss", "reconstruction", "validation_loss"]
    return [pd.DataFrame(row, columns=columns) for row in rows]


def _stateless(template: torch.nn.Module) -> Callable[..., tuple[Tensor, Tensor]]:
    # `vmap` does not split what has a keyword
    return lambda parameters, buffers, pictures, *arguments: functional_call(
        template, (parameters, buffers), arguments, pictures
    )


def _side_by_side(
    loss: Callable[..., tuple[Tensor, Tensor]], networks: int
) -> Callable[..., tuple[Tensor, Tensor]]:
    """`loss` of each network in a stack; `vmap` would make that of one a fifth slower."""
    if networks > 1:
        return vmap(loss)

    def of_one(stacked, buffers, pictures, *arguments):
        alone = [
            {key: value[0] for key, value in each.items()} for each in (stacked, buffers, pictures)
        ]
        minimised, reconstruction = loss(*alone, *(value[0] for value in arguments))
        return minimised[None], reconstruction[None]

    return of_one


def _order(part: range, generator: torch.Generator, wanted: int) -> Tensor:
    """`wanted` windows of `part`, none a second time before all others."""
    order = torch.randperm(len(part), generator=generator, device=generator.device)
    return part.start + order.repeat(-(-wanted // len(part)))[:wanted]


def _clipped(gradients: Sequence[Tensor]) -> list[Tensor]:
    """With a bounded norm for each network, which the first axis counts."""
    norms = torch.stack([g.flatten(1).norm(dim=1) for g in gradients]).norm(dim=0)
    scale = GRADIENT_NORM / norms.clamp(min=GRADIENT_NORM)
    # the fused optimiser takes a gradient to lie in memory as its parameter does
    return [(g * scale.view(-1, *[1] * (g.dim() - 1))).contiguous() for g in gradients]


@torch.no_grad()
def _unstack(stacked: dict[str, Tensor], modules: Sequence[torch.nn.Module]) -> None:
    for i, module in enumerate(modules):
        for name, parameter in module.named_parameters():
            parameter.copy_(stacked[name][i])


@torch.no_grad()
def _validation_loss(network: Network, data: Data) -> float:
    total = 0.0
    for index in torch.arange(len(data), device=data.observation.device).split(data.at_once):
        error = network.prediction_error(*data[index], **data.pictures(index))
        total += len(index) * float(error)
    return total / len(data)
