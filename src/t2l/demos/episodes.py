"""What the policies of a cell are trained on: its replays as one table, a row for each command."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from t2l.artefacts import read_arrow, whole
from t2l.errors import ArtefactError
from t2l.tasks import Task

OBSERVATION, ACTION, NUMBER = "observation", "action", "episode_index"


def write_episodes(
    episodes: Sequence[tuple[np.ndarray, np.ndarray]],
    path: Path | str,
    numbers: Sequence[int] | None = None,
) -> None:
    """Write a Parquet table: number of the episode, observation (n, nobs), action (n, nact).

    Args:
        numbers: ascending, of the demonstrations that they replay; by default all of them.
    """
    # it imports pandas
    from pyarrow.parquet import write_table

    observations, actions = zip(*episodes, strict=True)
    table = pa.table(
        {
            NUMBER: np.repeat(
                np.arange(len(actions)) if numbers is None else numbers,
                [len(action) for action in actions],
            ),
            OBSERVATION: _lists(np.concatenate(observations)),
            ACTION: _lists(np.concatenate(actions)),
        }
    )
    with whole(path) as draft:
        write_table(table, draft, write_page_checksum=True)


def read_episodes(path: Path | str, task: Task) -> list[tuple[np.ndarray, np.ndarray]]:
    """Observation (n, nobs) and action (n, nact) of every episode that `write_episodes` wrote.

    Raises:
        ArtefactError: the file is missing, cut short, or of another task.
    """
    path, sizes = Path(path), {OBSERVATION: len(task.observation_names), ACTION: None}
    table = read_arrow(path, [NUMBER, *sizes])
    if not table.num_rows:
        raise ArtefactError(path, "no rows", "the episodes of a cell")
    episodes = by_episode([path], [table], sizes)
    return [(episode[OBSERVATION], episode[ACTION]) for episode in episodes]


def read_numbers(path: Path | str) -> list[int]:
    """Which demonstrations the episodes replay that `write_episodes` wrote.

    Raises:
        ArtefactError: the file is missing or cut short.
    """
    table = read_arrow(Path(path), [NUMBER])
    return list(dict.fromkeys(_numbers(Path(path), table).tolist()))


def by_episode(
    files: Sequence[Path], tables: Sequence[pa.Table], sizes: Mapping[str, int | None]
) -> list[dict[str, np.ndarray]]:
    """The columns of lists in `sizes`, (n, size) each, cut where `episode_index` changes.

    Args:
        files: where the tables are from, one file each.
        sizes: how many numbers a list has, or None if that of the first row is right.

    Raises:
        ArtefactError: a column holds something else.
    """
    pairs = list(zip(files, tables, strict=True))
    values = {
        key: np.concatenate([_rows(file, table, key, size) for file, table in pairs])
        for key, size in sizes.items()
    }
    numbers = np.concatenate([_numbers(file, table) for file, table in pairs])
    starts = np.flatnonzero(np.diff(numbers)) + 1
    split = {key: np.split(value, starts) for key, value in values.items()}
    return [dict(zip(split, episode, strict=True)) for episode in zip(*split.values(), strict=True)]


def _lists(rows: np.ndarray) -> pa.Array:
    return pa.FixedSizeListArray.from_arrays(pa.array(rows.reshape(-1)), rows.shape[1])


def _rows(file: Path, table: pa.Table, key: str, size: int | None) -> np.ndarray:
    """A column of lists as (nrow, size)."""
    column = table[key].combine_chunks()
    lists = pa.types.is_list(column.type) or pa.types.is_fixed_size_list(column.type)
    if not lists or not pa.types.is_floating(column.type.value_type):
        raise ArtefactError(file, f"{key} is {column.type}", "lists of floating-point numbers")
    flat = column.flatten()
    lengths = column.value_lengths().unique().to_pylist()
    expected = f"lists of {'the same' if size is None else size} numbers"
    if len(lengths) != 1 or column.null_count or flat.null_count:
        raise ArtefactError(file, f"{key} has lists of other lengths", expected)
    if size not in (None, lengths[0]):
        raise ArtefactError(file, f"{key} has lists of {lengths[0]}", expected)
    return flat.to_numpy().reshape(-1, lengths[0])


def _numbers(file: Path, table: pa.Table) -> np.ndarray:
    column = table[NUMBER]
    if not pa.types.is_integer(column.type) or column.null_count:
        raise ArtefactError(file, f"{NUMBER} is {column.type}", "integers")
    return column.to_numpy()
