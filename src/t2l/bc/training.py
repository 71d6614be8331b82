"""From the retargeted demonstrations of cells to their policies."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any

import pandas as pd

from t2l.demos.episodes import read_episodes, read_numbers
from t2l.demos.pictures import read_pictures
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.policies import POLICIES, ClonedPolicy, Episode, Pictures, TrainingSet
from t2l.policies.validation import prediction_mse, split
from t2l.policies.windows import together
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
    views: Sequence[Pictures] = (),
) -> Iterator[tuple[ClonedPolicy, pd.DataFrame]]:
    """Train a policy for each cell and training seed, cell by cell.

    Args:
        data: each cell's table of episodes.
        seeds: numbers of the trainings of a cell.
        stage: base seed and names that the seed of a training is derived from.
        actions: names of an action's elements, without those of grippers.
        used: how many episodes are trained on, the same for all cells or by the cell's name.
        settings: the section `training`.
        views: the pictures of each demonstration (`views_of`), for policies that see by cameras,
            and else the robot's own state alone.

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
    for cell, episodes in _of_cells(task, data, used, views).items():
        for number in seeds:
            seed = torch_seed(*stage, cell.name, number)
            members.append((cell, number))
            sets.append(TrainingSet(*split(episodes, fraction, seed), seed))
    made = kind.fit_side_by_side(sets, kind.settings(**own), threads)
    for (cell, number), one, (policy, losses) in zip(members, sets, made, strict=True):
        error = prediction_mse(policy, one.validation)[: len(actions)].mean()
        yield (
            policy,
            losses.assign(kp=cell.kp, kd=cell.kd, seed=number, validation_mse_rad2=float(error)),
        )


def views_of(path: Path | str, cameras: Sequence[str], size_px: int) -> list[Pictures]:
    """The pictures of each demonstration, as `t2l.demos.pictures` wrote them.

    Raises:
        ArtefactError: they are missing, cut short, or of other cameras.
    """
    store, demonstrations = read_pictures(path, cameras, size_px)
    return [Pictures(store, frames) for frames in demonstrations]


def _of_cells(
    task: Task,
    data: Mapping[Cell, Path | str],
    used: int | Mapping[str, int] | None,
    views: Sequence[Pictures],
) -> dict[Cell, list[Episode]]:
    """Each cell's episodes to be trained on, in arrays that training need not copy."""
    read = {}
    for cell, path in data.items():
        most = used.get(cell.name) if isinstance(used, Mapping) else used
        # a copy, so that what is not used is let go
        read[cell] = together(_episodes(task, path, views)[:most])
    each = iter(together([*chain.from_iterable(read.values())]))
    return {cell: list(islice(each, len(episodes))) for cell, episodes in read.items()}


def _episodes(task: Task, path: Path | str, views: Sequence[Pictures]) -> list[Episode]:
    replays, own = read_episodes(path, task), task.robot_observation_size
    if not views:
        return [Episode(*replay, own) for replay in replays]
    numbers = read_numbers(path)
    for number, (_, action) in zip(numbers, replays, strict=True):
        if number >= len(views) or len(views[number].frames) != len(action):
            expected = "the same steps as there are pictures"
            raise ArtefactError(path, f"{len(action)} steps of demonstration {number}", expected)
    return [
        Episode(observation[:, :own], action, own, views[number])
        for number, (observation, action) in zip(numbers, replays, strict=True)
    ]
