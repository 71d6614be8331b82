"""Recordings from a LeRobot data set on disk (format 3), one for each episode.

The Parquet files are read as they are, because importing lerobot takes seconds. An episode's
`action` is the commanded position from its frame to the next, `observation.state` the measured one
at its frame.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from t2l.errors import RecordingError
from t2l.measurements.checks import COMMANDED, check_samples
from t2l.measurements.keys import Keys
from t2l.measurements.metadata import METADATA_KEYS, metadata_of
from t2l.measurements.recording import Recording

ACTION, STATE = "action", "observation.state"

# how data sets name the part of a feature that holds a joint's quantity
NAMES = {
    COMMANDED: ("{}", "{}.pos", "q_des.{}"),
    "q": ("{}", "{}.pos", "q.{}"),
    "dq": ("{}.vel", "dq.{}"),
    "tau": ("{}.effort", "{}.torque", "tau.{}"),
}


def read_lerobot(
    folder: Path | str,
    controller: Mapping[str, Any],
    degrees: bool = False,
    action_indices: Sequence[int] | None = None,
    state_indices: Sequence[int] | None = None,
    episodes: Sequence[int] | None = None,
) -> list[Recording]:
    """Recordings of a data set's episodes, in their order.

    Args:
        folder: of the data set, with `meta` and `data` in it.
        controller: what a recording's YAML would say; `command_rate_hz` is the data set's frame
            rate if absent.
        degrees: positions and velocities of the data set are in degrees.
        action_indices: where in `action` the joints are; by default found by name.
        state_indices: the same in `observation.state`.
        episodes: which; all by default.

    Raises:
        RecordingError: the data set cannot be read, joints are not found in it, or an episode is
            no recording.
    """
    folder = Path(folder)
    info = _read_info(folder)
    values = {"command_rate_hz": info["fps"], **controller}
    metadata = metadata_of(Keys(values, folder, METADATA_KEYS))
    joints = metadata["joints"]
    where = _find(folder, info["features"], joints, action_indices, state_indices)
    parts = _read_episodes(folder, info)
    recordings = []
    for episode in _chosen(folder, sorted(parts), episodes):
        frame, feature = parts[episode]
        factor = np.pi / 180 if degrees else 1.0
        signals = {
            kind: feature[key][:, indices] * (1.0 if kind == "tau" else factor)
            for kind, (key, indices) in where.items()
        }
        recording = Recording(
            name=f"{folder.resolve().name}_{episode:04d}",
            path=folder,
            # not the column timestamp, which is in single precision
            time=frame / info["fps"],
            **signals,
            **metadata,
        )
        try:
            check_samples(recording)
        except RecordingError as error:
            place = f"episode {episode}, {error.where}"
            raise RecordingError(folder, place, error.found, error.allowed) from None
        recordings.append(recording)
    return recordings


def _read_info(folder: Path) -> dict[str, Any]:
    path = folder / "meta" / "info.json"
    try:
        info = json.loads(path.read_text())
        version, fps, features = info["codebase_version"], info["fps"], info["features"]
    except FileNotFoundError:
        raise RecordingError(path, "the file", "nothing", "a LeRobot data set's folder") from None
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(
            path, "the file", f"what cannot be read ({error!r})", "a LeRobot data set's info.json"
        ) from None
    if not str(version).startswith("v3"):
        raise RecordingError(
            path, "key codebase_version", repr(version), "v3.0; lerobot converts older data sets"
        )
    if not isinstance(fps, int | float) or fps <= 0:
        raise RecordingError(path, "key fps", repr(fps), "a number above 0")
    for key in (ACTION, STATE):
        if key not in features:
            raise RecordingError(
                path,
                f"key features.{key}",
                "nothing",
                f"{ACTION} and {STATE}, with joint positions",
            )
    return info


def _find(
    folder: Path,
    features: Mapping[str, Any],
    joints: Sequence[str],
    action_indices: Sequence[int] | None,
    state_indices: Sequence[int] | None,
) -> dict[str, tuple[str, list[int]]]:
    """For every quantity that is there, the feature that holds it and the joints' places in it."""
    found = {}
    for kind, key, given in (
        (COMMANDED, ACTION, action_indices),
        ("q", STATE, state_indices),
        ("dq", STATE, None),
        ("tau", STATE, None),
    ):
        size = int(np.prod(features[key]["shape"]))
        names = _names(features[key])
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


def _names(feature: Mapping[str, Any]) -> list[str]:
    names = feature.get("names") or []
    # some data sets group their names: {motors: [...]}
    if isinstance(names, Mapping):
        names = [n for group in names.values() for n in (group if isinstance(group, list) else [])]
    return list(names)


def _index(names: Sequence[str], patterns: Sequence[str], joint: str) -> int | None:
    for pattern in patterns:
        if pattern.format(joint) in names:
            return list(names).index(pattern.format(joint))
    return None


def _read_episodes(
    folder: Path, info: Mapping[str, Any]
) -> dict[int, tuple[np.ndarray, dict[str, np.ndarray]]]:
    """By episode: frame numbers (n,), and each feature (n, size)."""
    try:
        files = sorted((folder / "data").glob("*/*.parquet"))
        columns = [ACTION, STATE, "episode_index", "frame_index"]
        table = pa.concat_tables(pq.read_table(file, columns=columns) for file in files)
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0]
        raise RecordingError(
            folder / "data", "the files", f"what cannot be read ({reason})", "Parquet files"
        ) from None
    total = info.get("total_frames", len(table))
    if len(table) != total or total == 0:
        raise RecordingError(
            folder / "data", "the files", f"{len(table)} frames", f"the {total} of meta/info.json"
        )
    features = {
        key: _matrix(table[key], int(np.prod(info["features"][key]["shape"])))
        for key in (ACTION, STATE)
    }
    episode_index, frame_index = (
        np.asarray(table[key].to_numpy()) for key in ("episode_index", "frame_index")
    )
    parts = {}
    for episode in np.unique(episode_index):
        rows = np.flatnonzero(episode_index == episode)
        rows = rows[np.argsort(frame_index[rows], kind="stable")]
        values = {key: value[rows] for key, value in features.items()}
        parts[int(episode)] = (frame_index[rows].astype(float), values)
    return parts


def _matrix(column: pa.ChunkedArray, size: int) -> np.ndarray:
    array = column.combine_chunks()
    if size > 1 or not pa.types.is_floating(array.type):
        array = array.flatten()
    return array.to_numpy(zero_copy_only=False).astype(float).reshape(-1, size)


def _chosen(folder: Path, there: Sequence[int], wanted: Sequence[int] | None) -> Sequence[int]:
    if wanted is None:
        return there
    for episode in wanted:
        if episode not in there:
            raise RecordingError(
                folder, f"episode {episode}", "nothing", f"{there[0]} to {there[-1]}"
            )
    return wanted
