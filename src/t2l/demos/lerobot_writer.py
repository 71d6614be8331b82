"""LeRobot data sets (format 3.0) of episodes of vectors, written as they are laid out on disk.

lerobot's own writer takes seconds to import and milliseconds a frame, because it is made for
images. A data set of vectors is one Parquet file of frames, and what describes it in `meta`: see
`lerobot.datasets.dataset_metadata`. A test has lerobot open one and compares it with its own.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
# what lerobot keeps of every frame, beside its features
FRAME = {"timestamp": "float32"} | dict.fromkeys(
    ("frame_index", "episode_index", "index", "task_index"), "int64"
)
FILE = "chunk-000/file-000.parquet"
# lerobot's own, for whoever adds episodes with it
LAYOUT = {
    "chunks_size": 1000,
    "data_files_size_in_mb": 100,
    "video_files_size_in_mb": 200,
    "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    "video_path": None,
}

type Episode = Mapping[str, np.ndarray]
type Statistics = dict[str, dict[str, list]]


def write_dataset(
    folder: Path,
    fps: int,
    names: Mapping[str, Sequence[str]],
    dtype: str,
    episodes: Iterable[Episode],
    instruction: str,
    robot_type: str,
) -> None:
    """Write a data set into a new folder.

    Args:
        names: of each feature, those of its elements.
        dtype: of every feature, `float32` or `float64`.
        episodes: by feature, (nframe, size) each.
        instruction: the task of every episode, in words.
    """
    meta = folder / "meta"
    for path in (folder / "data" / FILE, meta / "episodes" / FILE):
        path.parent.mkdir(parents=True)
    columns = {
        **{key: pa.list_(getattr(pa, dtype)(), len(own)) for key, own in names.items()},
        **{key: getattr(pa, kind)() for key, kind in FRAME.items()},
    }
    # one row group an episode, so that each can be read alone
    rows, whole, start = [], {key: [] for key in columns}, 0
    with pq.ParquetWriter(folder / "data" / FILE, pa.schema(columns)) as writer:
        for number, given in enumerate(episodes):
            episode = {key: np.asarray(given[key], dtype=dtype) for key in names}
            length = len(next(iter(episode.values())))
            episode |= _frame_columns(number, start, length, fps)
            arrays = [
                pa.array(value.ravel(), pa.from_numpy_dtype(value.dtype))
                for value in episode.values()
            ]
            lists = [
                pa.FixedSizeListArray.from_arrays(array, len(names[key])) if key in names else array
                for key, array in zip(columns, arrays, strict=True)
            ]
            writer.write_table(pa.table(lists, schema=pa.schema(columns)))
            rows.append(_episode_row(number, start, length, instruction, statistics(episode)))
            for key, value in episode.items():
                whole[key].append(value)
            start += length
    pd.DataFrame(rows).to_parquet(meta / "episodes" / FILE, index=False)
    tasks = pd.DataFrame({"task_index": [0]}, index=pd.Index([instruction], name="task"))
    tasks.to_parquet(meta / "tasks.parquet")
    everything = statistics({key: np.concatenate(parts) for key, parts in whole.items()})
    info = {
        "codebase_version": "v3.0",
        "fps": fps,
        "features": {
            **{
                key: {"dtype": dtype, "shape": [len(own)], "names": list(own)}
                for key, own in names.items()
            },
            **{key: {"dtype": kind, "shape": [1], "names": None} for key, kind in FRAME.items()},
        },
        "total_episodes": len(rows),
        "total_frames": start,
        "total_tasks": 1,
        **LAYOUT,
        "robot_type": robot_type,
        "splits": {"train": f"0:{len(rows)}"},
    }
    for name, content in (("stats", everything), ("info", info)):
        (meta / f"{name}.json").write_text(json.dumps(content, indent=4), encoding="utf-8")


def statistics(columns: Episode) -> Statistics:
    """Of every column (nframe,) or (nframe, size), over its frames."""
    found = {}
    for key, values in columns.items():
        rows = values.reshape(len(values), -1).astype(float)
        of_column = {
            "min": rows.min(axis=0),
            "max": rows.max(axis=0),
            "mean": rows.mean(axis=0),
            "std": rows.std(axis=0),
            "count": np.array([len(rows)]),
            **dict(zip(QUANTILES, np.quantile(rows, [*QUANTILES.values()], axis=0), strict=True)),
        }
        found[key] = {name: value.tolist() for name, value in of_column.items()}
    return found


def _frame_columns(number: int, start: int, length: int, fps: int) -> dict[str, np.ndarray]:
    """The columns `FRAME` of an episode whose first frame is `start`."""
    frame = np.arange(length)
    values = (frame / fps, frame, np.full(length, number), start + frame, np.zeros(length))
    return {
        key: value.astype(kind) for (key, kind), value in zip(FRAME.items(), values, strict=True)
    }


def _episode_row(
    number: int, start: int, length: int, instruction: str, found: Statistics
) -> dict[str, object]:
    """What `meta/episodes` says of an episode."""
    return {
        "episode_index": number,
        "tasks": [instruction],
        "length": length,
        "data/chunk_index": 0,
        "data/file_index": 0,
        "dataset_from_index": start,
        "dataset_to_index": start + length,
        **{
            f"stats/{key}/{name}": value
            for key, of_column in found.items()
            for name, value in of_column.items()
        },
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
    }
