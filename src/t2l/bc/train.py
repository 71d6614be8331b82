"""Training a `ChunkCVAE` on the demonstrations of one cell."""

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch

from t2l.bc.windows import Episode, Windows
from t2l.policies.chunk_cvae import Architecture, ChunkCVAE

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class TrainingSettings:
    """The `training` section of the configuration; see config/README.md."""

    history: int
    chunk: int
    latent: int
    hidden: tuple[int, ...]
    kl_weight: float
    epochs: int
    batch_size: int
    learning_rate: float
    weight_decay: float
    observation_noise: float
    validation_fraction: float


def train(
    episodes: Sequence[Episode],
    settings: TrainingSettings,
    seed: int,
    threads: int = 1,
    device: str | None = None,
) -> tuple[ChunkCVAE, pd.DataFrame]:
    """Train from scratch; the same seed on the same machine gives the same weights.

    Args:
        device: a torch device; by default the GPU if there is one.

    Returns:
        The policy, and one row per epoch: epoch, training_loss, reconstruction, validation_loss.
        Losses are mean squared errors of normalised actions; the validation loss is that of
        acting (zero latent) on whole episodes that were held out.

    Raises:
        ValueError: fewer than two episodes, so that none can be held out.
    """
    if len(episodes) < 2:
        raise ValueError(f"{len(episodes)} episodes cannot be split into training and validation")
    device = torch.device(device or ("cuda" if torch.cuda.is_available() else "cpu"))
    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(True, warn_only=True)
    torch.manual_seed(seed)

    held_out = max(1, round(settings.validation_fraction * len(episodes)))
    order = np.random.default_rng(seed).permutation(len(episodes))
    validation, training = (
        Windows([episodes[i] for i in part], settings.history, settings.chunk, device)
        for part in (order[:held_out], order[held_out:])
    )
    policy = ChunkCVAE(
        Architecture(
            observation_size=training.observation.shape[1],
            action_size=training.action.shape[1],
            history=settings.history,
            chunk=settings.chunk,
            latent=settings.latent,
            hidden=tuple(settings.hidden),
        )
    ).to(device)
    policy.normalise_by(training.observation, training.action)
    batches = -(-len(training) // settings.batch_size)
    optimiser = torch.optim.AdamW(
        policy.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, settings.learning_rate, total_steps=settings.epochs * batches, pct_start=0.1
    )
    rows = []
    start = time.monotonic()
    for epoch in range(1, settings.epochs + 1):
        totals = torch.zeros(2, device=device)
        for index in torch.randperm(len(training), device=device).split(settings.batch_size):
            loss, reconstruction = policy.loss(
                *training[index], settings.kl_weight, settings.observation_noise
            )
            optimiser.zero_grad(set_to_none=True)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            totals += len(index) * torch.stack([loss.detach(), reconstruction.detach()])
        training_loss, reconstruction = (totals / len(training)).tolist()
        rows.append((epoch, training_loss, reconstruction, _validation_loss(policy, validation)))
        elapsed = time.monotonic() - start
        log.info(
            "epoch %d of %d: training loss %.5f, validation loss %.5f, %.0f s left",
            *(epoch, settings.epochs, training_loss, rows[-1][-1]),
            elapsed / epoch * (settings.epochs - epoch),
        )
    columns = ["epoch", "training_loss", "reconstruction", "validation_loss"]
    return policy.eval(), pd.DataFrame(rows, columns=columns)


@torch.no_grad()
def _validation_loss(policy: ChunkCVAE, windows: Windows) -> float:
    total = 0.0
    for index in torch.arange(len(windows)).split(4096):
        total += len(index) * float(policy.prediction_error(*windows[index]))
    return total / len(windows)
