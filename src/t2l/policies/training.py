"""Training of torch networks on windows of episodes: AdamW with a one-cycle schedule.

Networks of one shape are trained side by side, each on data and with random numbers of its own, as
one stack of parameters (`torch.func`). One alone is a stack of one. A processor gains nothing by
more of them; a GPU trains dozens in the time of one.
"""

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
import pandas as pd
import torch
from torch import Tensor
from torch.func import functional_call, vmap

from t2l.policies.captured import Captured
from t2l.policies.rows import Rows
from t2l.policies.training_settings import TrainingSettings

log = logging.getLogger(__name__)

# largest norm of a gradient, a usual bound for networks of this size
GRADIENT_NORM = 1.0
RISE = 0.1  # of the steps, in which the learning rate rises


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
    networks: Iterable[N],
    data: Rows,
    training: Sequence[Tensor],
    validation: Sequence[Tensor],
    settings: TrainingSettings,
    seeds: Sequence[int],
) -> list[tuple[N, pd.DataFrame]]:
    """Minimise each network's loss on its own data, in place.

    Every batch is full: where an order of windows ends before its epoch does, it begins again.

    Args:
        networks: each a `Network` too, of the same shape. One is asked for when the one before has
            its place in the stack, so that weights are held once.
        data: of all networks.
        training: each network's rows of `data` to learn from, (n,).
        validation: each network's to be judged by.
        seeds: of each network's order of windows and of its draws.

    Returns:
        Each network, whose parameters are now a part of the stack, and one row an epoch: epoch,
        training_loss, reconstruction, validation_loss.
    """
    device, size = data.observation.device, settings.batch_size
    batches = max(-(-len(rows) // size) for rows in training)
    generators = [torch.Generator(device).manual_seed(seed) for seed in seeds]
    modules, stacked, buffers = _stack(map(_Loss, networks), len(seeds))
    trained, parameters = [module.network for module in modules], list(stacked.values())
    optimiser = torch.optim.AdamW(
        parameters, lr=settings.learning_rate, weight_decay=settings.weight_decay, fused=True
    )
    steps = settings.epochs * batches
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        # a rise of exactly one step is one that torch divides by zero for
        *(optimiser, settings.learning_rate, steps),
        pct_start=RISE if RISE * steps != 1 else 2 * RISE,
    )
    losses = _side_by_side(_stateless(modules[0]), len(trained))

    def gradients_of(*arguments: Tensor, **pictures: Tensor) -> tuple[Tensor, ...]:
        minimised, reconstruction = losses(stacked, buffers, pictures, *arguments)
        gradients = list(torch.autograd.grad(minimised.sum(), parameters))
        return torch.stack([minimised, reconstruction]).detach(), *_clipped(gradients)

    step = Captured(gradients_of)
    order = torch.empty(len(trained), batches * size, dtype=torch.int32, device=device)
    rows, start = [[] for _ in trained], time.monotonic()
    for epoch in range(1, settings.epochs + 1):
        totals = torch.zeros(2, len(trained), device=device)
        for own, *pair in zip(order, training, generators, strict=True):
            own.copy_(_order(*pair, batches * size))
        for index in order.split(size, dim=1):
            drawn = _drawn(trained, generators, size)
            found, *gradients = step(*data[index], *drawn, **data.pictures(index))
            for parameter in parameters:
                parameter.grad = gradients.pop(0)
            optimiser.step()
            # not to be kept until there are the next ones
            optimiser.zero_grad()
            schedule.step()
            totals += found
        for i, found in enumerate((totals / batches).T.tolist()):
            rows[i].append((epoch, *found, _validation_loss(trained[i], data, validation[i])))
        elapsed = time.monotonic() - start
        log.info(
            "epoch %d of %d: training loss %.5f, validation loss %.5f, %.0f s left",
            *(epoch, settings.epochs, *np.mean([row[-1] for row in rows], axis=0)[[1, 3]]),
            elapsed / epoch * (settings.epochs - epoch),
        )
    columns = ["epoch", "training_loss", "reconstruction", "validation_loss"]
    return [
        (network, pd.DataFrame(row, columns=columns))
        for network, row in zip(trained, rows, strict=True)
    ]


def _stack(
    modules: Iterable[torch.nn.Module], count: int
) -> tuple[list[torch.nn.Module], dict[str, Tensor], dict[str, Tensor]]:
    """`count` modules of one shape, and a stack of each of their parameters and buffers.

    Their parameters become parts of the stacks.
    """
    made, stacked = [], {}
    for i, module in enumerate(modules):
        for name, parameter in module.named_parameters():
            if name not in stacked:
                stacked[name] = parameter.new_empty(count, *parameter.shape)
            stacked[name][i] = parameter.data
            parameter.data = stacked[name][i]
        made.append(module)
    own = [dict(module.named_buffers()) for module in made]
    buffers = {name: torch.stack([each[name] for each in own]) for name in own[0]}
    return made, {name: stack.requires_grad_() for name, stack in stacked.items()}, buffers


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


def _order(rows: Tensor, generator: torch.Generator, wanted: int) -> Tensor:
    """`wanted` of the rows, none a second time before all others."""
    order = torch.randperm(len(rows), generator=generator, device=generator.device)
    return rows[order].repeat(-(-wanted // len(rows)))[:wanted]


def _drawn(
    networks: Sequence[Network], generators: Sequence[torch.Generator], n: int
) -> list[Tensor]:
    """What the losses of n windows of each network take at random."""
    draws = [one.draws(n, own) for one, own in zip(networks, generators, strict=True)]
    return [torch.stack(each) for each in zip(*draws, strict=True)]


def _clipped(gradients: list[Tensor]) -> Iterator[Tensor]:
    """With a bounded norm for each network, which the first axis counts; takes them away."""
    norms = torch.stack([g.flatten(1).norm(dim=1) for g in gradients]).norm(dim=0)
    scale = GRADIENT_NORM / norms.clamp(min=GRADIENT_NORM)
    while gradients:
        gradient = gradients.pop(0)
        scaled = gradient * scale.view(-1, *[1] * (gradient.dim() - 1))
        # the fused optimiser takes a gradient to lie in memory as its parameter does
        yield scaled.contiguous()


@torch.no_grad()
def _validation_loss(network: Network, data: Rows, rows: Tensor) -> float:
    total = 0.0
    for index in rows.split(data.at_once):
        error = network.prediction_error(*data[index], **data.pictures(index))
        total += len(index) * float(error)
    return total / len(rows)
