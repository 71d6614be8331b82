"""Sizes that are fine by themselves, and too much for a machine together."""

from collections.abc import Iterator, Mapping
from math import prod

from t2l.config.cells import transfer_cells
from t2l.config.models import Configuration
from t2l.config.models.cloning import Training
from t2l.policies.training_settings import TrainingSettings
from t2l.tasks import Demonstrated, Task
from t2l.typed import Problem


def problems(configuration: Configuration, tasks: Mapping[str, Task]) -> list[Problem]:
    """Products of keys that are too large.

    Args:
        tasks: those of the study that could be made, by name.
    """
    return [
        Problem(
            keys, " × ".join(f"{factor:g}" for factor in factors), f"a product of at most {most}"
        )
        for keys, factors, most in _products(configuration, tasks)
        if prod(factors) > most
    ]


def _products(
    c: Configuration, tasks: Mapping[str, Task]
) -> Iterator[tuple[str, tuple[float, ...], int]]:
    """Keys, what they hold, and the most that their product may be."""
    # each is a job, with files of its own
    keys = "grid.kp, grid.kd, tasks, variants, training_seeds, collections"
    cells = len(c.grid.kp), len(c.grid.kd)
    policies = c.training_seeds, c.collections
    yield keys, (*cells, len(c.tasks), 1 + len(c.variants), *policies), 20_000
    keys = "recording_grid cells, sim_to_real.conditions, tuning.workers"
    conditions = max(1, len(c.sim_to_real.conditions))
    yield keys, (len(transfer_cells(c)), conditions, c.tuning.workers), 20_000
    # seconds that are kept: at most 250 kB each at 500 Hz, 100 kB each below
    horizon_s = max(
        (task.horizon_s for task in tasks.values() if isinstance(task, Demonstrated)), default=0
    )
    yield "demonstrations.count, horizon_s of a task", (c.demonstrations.count, horizon_s), 50_000
    if c.operator:
        keys = "operator.crossover_rad_s, operator.practice, horizon_s of a task"
        tried = len(c.operator.crossover_rad_s), c.operator.practice
        yield keys, (*tried, horizon_s), 20_000
    yield "rollouts.count, horizon_s of a task", (c.rollouts.count, horizon_s), 100_000
    # bytes: what a training holds in memory
    keys = "demonstrations.count, horizon_s of a task, retargeting.policy_rate_hz, "
    keys += "observation.cameras, 3 × observation.size_px²"
    steps = c.demonstrations.count, horizon_s, c.retargeting.policy_rate_hz
    view = len(c.observation.cameras), 3 * c.observation.size_px**2
    yield keys, (*steps, *view), 3_000_000_000
    yield "attenuation.replays, horizon_s of a task", (c.attenuation.replays, horizon_s), 100_000
    # joints side by side, some hundred bytes each
    keys = "grid.kp, grid.kd, attenuation.replicates, attenuation.inertias_kg_m2"
    cells, joints = len(c.grid.kp) * len(c.grid.kd), len(c.attenuation.inertias_kg_m2) + 1
    yield keys, (cells, c.attenuation.replicates, joints), 10_000_000
    keys = "identification.population, recordings.duration_s"
    yield keys, (c.identification.population, c.recordings.duration_s), 50_000
    learning = c.reinforcement_learning
    keys = "deployment.rollouts, reinforcement_learning.horizon_s"
    yield keys, (c.deployment.rollouts, learning.horizon_s), 20_000
    # simulated seconds of all episodes at once, fifty times the study's
    keys = "reinforcement_learning.environments, reinforcement_learning.horizon_s"
    yield keys, (learning.environments, learning.horizon_s), 200_000
    # policy steps of some 60 numbers each: 2.4 GB of a batch, 240 MB of a layer's weights
    training = c.training
    if not isinstance(training, TrainingSettings):
        return
    steps = training.history + training.chunk
    keys = "training.batch_size, training.history + training.chunk"
    yield keys, (training.batch_size, steps), 10_000_000
    if isinstance(training, Training):
        keys = "training.hidden, training.history + training.chunk"
        yield keys, (max(training.hidden), steps), 1_000_000
