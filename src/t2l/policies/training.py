"""Training of torch networks on windows of episodes: AdamW with a one-cycle schedule."""

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from t2l.policies.policy import Episode
from t2l.policies.training_settings import TrainingSettings
from t2l.policies.windows import Windows

log = logging.getLogger(__name__)

# (history, chunk) of a batch to what is minimised and the part of it that is the actions' error
Loss = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]


class Predictor(Protocol):
    """A network that can be judged on windows."""

    def prediction_error(self, history: Tensor, chunk: Tensor) -> Tensor:
        """Mean squared error of normalised actions when acting, a scalar."""


@contextmanager
def reproducible(seed: int, threads: int) -> Iterator[torch.device]:
    """Make what torch draws and computes within depend on the seed alone; gives the device to use.

    That is the GPU if there is one. Generators, threads and settings are as before afterwards.
    """
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    before = torch.get_num_threads()
    deterministic = torch.are_deterministic_algorithms_enabled()
    warning = torch.is_deterministic_algorithms_warn_only_enabled()
    with torch.random.fork_rng([device] if device.type == "cuda" else []):
        torch.manual_seed(seed)
        torch.set_num_threads(threads)
        torch.use_deterministic_algorithms(True, warn_only=True)
        try:
            yield device
        finally:
            torch.set_num_threads(before)
            torch.use_deterministic_algorithms(deterministic, warn_only=warning)


def split(
    episodes: Sequence[Episode], settings: TrainingSettings, seed: int, device: torch.device
) -> tuple[Windows, Windows]:
    """Windows to train on, and those of whole episodes that are held out.

    Raises:
        ValueError: fewer than two episodes, so that none can be held out.
    """
    if len(episodes) < 2:
        raise ValueError(f"{len(episodes)} episodes cannot be split into training and validation")
    held_out = max(1, round(settings.validation_fraction * len(episodes)))
    order = np.random.default_rng(seed).permutation(len(episodes))
    validation, training = (
        Windows([episodes[i] for i in part], settings.history, settings.chunk, device)
        for part in (order[:held_out], order[held_out:])
    )
    return training, validation


def train[N: torch.nn.Module](
    network: N, loss: Loss, training: Windows, validation: Windows, settings: TrainingSettings
) -> pd.DataFrame:
    """Minimise `loss` by a network's parameters, in place.

    Args:
        network: a `Predictor` too.

    Returns:
        One row an epoch: epoch, training_loss, reconstruction, validation_loss.
    """
    device = training.observation.device
    batches = -(-len(training) // settings.batch_size)
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, settings.learning_rate, total_steps=settings.epochs * batches, pct_start=0.1
    )
    rows = []
    start = time.monotonic()
    for epoch in range(1, settings.epochs + 1):
        totals = torch.zeros(2, device=device)
        for index in torch.randperm(len(training), device=device).split(settings.batch_size):
            minimised, reconstruction = loss(*training[index])
            optimiser.zero_grad(set_to_none=True)
            minimised.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            totals += len(index) * torch.stack([minimised.detach(), reconstruction.detach()])
        training_loss, reconstruction = (totals / len(training)).tolist()
        rows.append((epoch, training_loss, reconstruction, _validation_loss(network, validation)))
        elapsed = time.monotonic() - start
        log.info(
            "epoch %d of %d: training loss %.5f, validation loss %.5f, %.0f s left",
            *(epoch, settings.epochs, training_loss, rows[-1][-1]),
            elapsed / epoch * (settings.epochs - epoch),
        )
    columns = ["epoch", "training_loss", "reconstruction", "validation_loss"]
    return pd.DataFrame(rows, columns=columns)


@torch.no_grad()
def _validation_loss(network: Predictor, windows: Windows) -> float:
    total = 0.0
    for index in torch.arange(len(windows)).split(4096):
        total += len(index) * float(network.prediction_error(*windows[index]))
    return total / len(windows)
