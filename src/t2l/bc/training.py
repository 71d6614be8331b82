"""From the retargeted demonstrations of cells to their policies."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from t2l.demos.episodes import read_episodes
from t2l.gains import Cell
from t2l.policies import POLICIES, ClonedPolicy, Episode, TrainingSet
from t2l.policies.validation import prediction_mse, split
from t2l.seeds import torch_seed
from t2l.tasks import Task

LOSS_COLUMNS = ("kp", "kd", "seed", "epoch", "validation_loss", "validation_mse_rad2")


def train(
    task: Task,
    data: Mapping[Cell, Path | str],
    seeds: Sequence[int],
    stage: tuple[int, str, str],
    actions: Sequence[str],
    used: int | Mapping[str, int] | None,
    settings: Mapping[str, Any],
    threads: int = 1,
) -> Iterator[tuple[ClonedPolicy, pd.DataFrame]]:
    """Train a policy for each cell and training seed, cell by cell.

    Args:
        data: each cell's table of episodes.
        seeds: numbers of the trainings of a cell.
        stage: base seed and names that the seed of a training is derived from.
        actions: names of an action's elements, without those of grippers.
        used: how many episodes are trained on, the same for all cells or by the cell's name.
        settings: the section `training`.

    Yields:
        The policy, and one row an epoch with columns `LOSS_COLUMNS` and those of the policy's own;
        `validation_mse_rad2` is that of the trained policy, over the elements of `actions`, in
        every row.

    Raises:
        ArtefactError: a table is missing, cut short or foreign.
    """
    own = dict(settings)
    kind, fraction = POLICIES.find(own.pop("policy")), own.pop("validation_fraction")
    members, sets = [], []
    for cell, path in data.items():
        replays = read_episodes(path, task)
        episodes = [Episode(*replay, task.robot_observation_size) for replay in replays]
        most = used.get(cell.name) if isinstance(used, Mapping) else used
        for number in seeds:
            seed = torch_seed(*stage, cell.name, number)
            members.append((cell, number))
            sets.append(TrainingSet(*split(episodes[:most], fraction, seed), seed))
    made = kind.fit_side_by_side(sets, kind.settings(**own), threads)
    for (cell, number), one, (policy, losses) in zip(members, sets, made, strict=True):
        error = prediction_mse(policy, one.validation)[: len(actions)].mean()
        yield (
            policy,
            losses.assign(kp=cell.kp, kd=cell.kd, seed=number, validation_mse_rad2=float(error)),
        )
