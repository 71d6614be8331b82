"""A LeRobot data set on disk (format 3): what it says of itself, its episodes, where joints are."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import Field

from t2l.documents import check_regular, check_size, read_json
from t2l.errors import RecordingError
from t2l.recordings.checks import COMMANDED
from t2l.recordings.keys import checked
from t2l.recordings.metadata import LARGEST_RATE_HZ
from t2l.typed import AsTuple, Integer, Number, Typed, describe

ACTION, STATE = "action", "observation.state"

# how data sets name the part of a feature that holds a joint's quantity
NAMES = {
    COMMANDED: ("{}", "{}.pos", "q_des.{}"),
    "q": ("{}", "{}.pos", "q.{}"),
    "dq": ("{}.vel", "dq.{}"),
    "tau": ("{}.effort", "{}.torque", "tau.{}"),
}


class Feature(Typed, extra="ignore"):
    """A feature of a data set; what else it says is not needed."""

    shape: Annotated[tuple[Annotated[Integer, Field(ge=1, le=100_000)], ...], AsTuple]
    names: Any = None


class Info(Typed, extra="ignore"):
    """What `meta/info.json` must say; what else it says is not needed."""

    codebase_version: str
    fps: Annotated[
        Number, Field(gt=0, le=LARGEST_RATE_HZ, description="a number above 0, frames a second")
    ]
    total_frames: Annotated[Integer | None, Field(ge=0)] = None
    features: Annotated[dict[str, Any], Field(description=f"{ACTION} and {STATE}, with joints")]


def read_info(folder: Path) -> Info:
    """What `meta/info.json` says.

    Raises:
        RecordingError: it cannot be read, is of another format, or holds no joint positions.
    """
    path = folder / "meta" / "info.json"
    content = read_json(path, "a LeRobot data set's meta/info.json")
    found = checked(Info, content, path)
    if not found.codebase_version.startswith("v3"):
        raise RecordingError(
            path,
            "key codebase_version",
            describe(found.codebase_version),
            "v3.0; lerobot converts older data sets",
        )
    features = dict(found.features)
    for key in (ACTION, STATE):
        if key not in features:
            raise RecordingError(
                path,
                f"key features.{key}",
                "nothing",
                f"{ACTION} and {STATE}, with joint positions",
            )
        feature = features[key] = feature_of(features, key, path)
        if len(feature.shape) != 1:
            shape = describe(feature.shape)
            raise RecordingError(path, f"key features.{key}.shape", shape, "one number")
    return found.model_copy(update={"features": features})


def feature_of(features: Mapping[str, Any], key: str, path: Path) -> Feature:
    """A feature that is there, checked.

    Raises:
        RecordingError: it is described wrongly.
    """
    return checked(Feature, features[key], path, f"features.{key}.")


def find(
    folder: Path,
    features: Mapping[str, Any],
    joints: Sequence[str],
    action_indices: Sequence[int] | None,
    state_indices: Sequence[int] | None,
) -> dict[str, tuple[str, list[int]]]:
    """For every quantity that is there, the feature that holds it and the joints' places in it.

    Raises:
        RecordingError: positions of a joint are not found, or indices lead nowhere.
    """
    found = {}
    for kind, key, given in (
        (COMMANDED, ACTION, action_indices),
        ("q", STATE, state_indices),
        ("dq", STATE, None),
        ("tau", STATE, None),
    ):
        (size,) = features[key].shape
        names = names_of(features[key].names)
        where = folder / "meta" / "info.json"
        if given is not None:
            if len(given) != len(joints) or not all(0 <= i < size for i in given):
                raise RecordingError(
                    where,
                    f"indices into {key}",
                    f"{list(given)}",
                    f"{len(joints)}, one for each joint, from 0 to {size - 1}",
                )
            found[kind] = (key, list(given))
            continue
        indices = [_index(names, NAMES[kind], joint) for joint in joints]
        if None not in indices:
            found[kind] = (key, indices)
        elif kind in (COMMANDED, "q"):
            joint = joints[indices.index(None)]
            listed = ", ".join(map(str, names)) or f"{size} numbers without names"
            raise RecordingError(
                where,
                f"key features.{key}",
                listed,
                f"{joint} among the names, or the joints' indices given explicitly",
            )
    return found


def names_of(names: Any) -> list[str]:
    """What the parts of a feature are called, as its `names` say; nothing if they do not."""
    # some data sets group their names: {motors: [...]}
    groups = list(names.values()) if isinstance(names, Mapping) else [names]
    return [str(n) for group in groups if isinstance(group, list) for n in group]


def _index(names: Sequence[str], patterns: Sequence[str], joint: str) -> int | None:
    for pattern in patterns:
        if pattern.format(joint) in names:
            return list(names).index(pattern.format(joint))
    return None


def read_episodes(
    folder: Path, info: Info, more: Sequence[str] = ()
) -> dict[int, tuple[np.ndarray, dict[str, np.ndarray]]]:
    """By episode: frame numbers (n,), and each feature (n, size).

    Args:
        more: features beside action and state, of numbers too.

    Raises:
        RecordingError: the files cannot be read or are not all there.
    """
    where = folder / "data"
    keys, counters = (ACTION, STATE, *more), ("episode_index", "frame_index")
    columns = [*keys, *counters]
    try:
        files = sorted(where.glob("*/*.parquet"))
        for file in files:
            check_regular(file, RecordingError)
            check_size(pq.ParquetFile(file), file, RecordingError)
        table = pa.concat_tables(pq.read_table(file, columns=columns) for file in files)
        missing = [name for name in columns if name not in table.column_names]
        if missing:
            raise RecordingError(where, f"column {missing[0]}", "nothing", ", ".join(columns))
        numbers = {name: _numbers(table[name], name, where) for name in counters}
        features = {
            key: _matrix(table[key], info.features[key].shape[0], key, where) for key in keys
        }
    # ValueError: no file at all
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise RecordingError(
            where, "the files", f"what cannot be read ({reason})", "Parquet files"
        ) from None
    total = len(table) if info.total_frames is None else info.total_frames
    if len(table) != total or total == 0:
        raise RecordingError(
            where, "the files", f"{len(table)} frames", f"the {total} of meta/info.json"
        )
    parts = {}
    episode_index, frame_index = numbers["episode_index"], numbers["frame_index"]
    for episode in np.unique(episode_index):
        rows = np.flatnonzero(episode_index == episode)
        rows = rows[np.argsort(frame_index[rows], kind="stable")]
        values = {key: value[rows] for key, value in features.items()}
        parts[int(episode)] = (frame_index[rows].astype(float), values)
    return parts


def _numbers(column: pa.ChunkedArray, name: str, where: Path) -> np.ndarray:
    """Whole numbers (n,)."""
    if not pa.types.is_integer(column.type) or column.null_count:
        found = f"{column.type} cells" + (", some empty" if column.null_count else "")
        raise RecordingError(where, f"column {name}", found, "whole numbers")
    return column.combine_chunks().to_numpy(zero_copy_only=False)


def _matrix(column: pa.ChunkedArray, size: int, name: str, where: Path) -> np.ndarray:
    """Numbers (n, size)."""
    array = column.combine_chunks()
    if isinstance(array, pa.ChunkedArray):
        array = pa.concat_arrays(array.chunks)
    rows = len(array)
    listed = isinstance(array, pa.ListArray | pa.LargeListArray | pa.FixedSizeListArray)
    flat = array.flatten() if listed else array
    number = pa.types.is_floating(flat.type) or pa.types.is_integer(flat.type)
    if not number or array.null_count or len(flat) != rows * size:
        found = f"{array.type} cells" + (", some empty" if array.null_count else "")
        if number and not array.null_count:
            found = f"{len(flat)} numbers in {rows} rows"
        raise RecordingError(where, f"column {name}", found, f"{size} numbers in each row")
    return flat.to_numpy(zero_copy_only=False).astype(float).reshape(-1, size)


def chosen(folder: Path, there: Sequence[int], wanted: Sequence[int] | None) -> Sequence[int]:
    """Episodes that are wanted; all by default.

    Raises:
        RecordingError: one is not there.
    """
    if wanted is None:
        return there
    for episode in wanted:
        if episode not in there:
            raise RecordingError(
                folder, f"episode {episode}", "nothing", f"{there[0]} to {there[-1]}"
            )
    return wanted
