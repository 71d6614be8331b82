"""Recordings from a LeRobot data set on disk (format 3), one for each episode.

The Parquet files are read as they are, because importing lerobot takes seconds. An episode's
`action` is the commanded position from its frame to the next, `observation.state` the measured one
at its frame.
"""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.checks import COMMANDED, MOST_RAD, check_samples
from t2l.recordings.importers.lerobot_dataset import (
    ACTION,
    STATE,
    chosen,
    find,
    names_of,
    read_episodes,
    read_info,
)
from t2l.recordings.metadata import check_metadata
from t2l.recordings.recording import Recording

logger = logging.getLogger(__name__)

MOST_DEG = MOST_RAD * 180 / np.pi  # format: the largest number for a position of any data set


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
    info = read_info(folder)
    values = {"command_rate_hz": info.fps, **controller}
    metadata = check_metadata(values, folder)
    joints = metadata["joints"]
    where = find(folder, info.features, joints, action_indices, state_indices)
    parts = read_episodes(folder, info)
    recordings = []
    for episode in chosen(folder, sorted(parts), episodes):
        frame, feature = parts[episode]
        factor = np.pi / 180 if degrees else 1.0  # format: rad
        signals = {
            kind: feature[key][:, indices] * (1.0 if kind == "tau" else factor)
            for kind, (key, indices) in where.items()
        }
        recording = Recording(
            name=f"{folder.resolve().name}_{episode:04d}",
            path=folder,
            # not the column timestamp, which is in single precision
            time=frame / info.fps,
            **signals,
            **metadata,
        )
        try:
            recordings.append(check_samples(recording))
        except RecordingError as error:
            place = f"episode {episode}, {error.where}"
            raise RecordingError(folder, place, error.found, error.allowed) from None
    return recordings


def read_lerobot_positions(
    folder: Path | str,
    joints: Sequence[str] | None = None,
    episodes: Sequence[int] | None = None,
) -> tuple[tuple[str, ...], list[tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """Commanded and measured positions of a data set, whatever its controller and units were.

    Args:
        joints: names in `action` and `observation.state`; by default all that are in both.

    Returns:
        The joints, and of each episode times (n,) s, commands and positions (n, njoint).

    Raises:
        RecordingError: the data set cannot be read, or joints or episodes are not in it.
    """
    folder = Path(folder)
    info = read_info(folder)
    actions, states = (names_of(info.features[key].names) for key in (ACTION, STATE))
    if joints is None:
        joints = [name for name in actions if name in states]
        if not joints:
            path = folder / "meta" / "info.json"
            listed = f"{', '.join(actions) or 'none'} and {', '.join(states) or 'none'}"
            allowed = f"joints of the same names in {ACTION} and {STATE}"
            raise RecordingError(path, "names of features", listed, allowed)
    where = find(folder, info.features, joints, None, None)
    parts = read_episodes(folder, info)
    rows = []
    for episode in chosen(folder, sorted(parts), episodes):
        frame, feature = parts[episode]
        command, q = (feature[key][:, at] for key, at in (where[COMMANDED], where["q"]))
        for key, values in ((ACTION, command), (STATE, q)):
            _check_size(folder, episode, frame, key, values)
        order = np.isfinite(command).all(axis=1)
        if not order.all():
            logger.warning(
                "%s: episode %d: %d of %d frames left out, without a command",
                folder, episode, np.sum(~order), len(order),
            )  # fmt: skip
        rows.append((frame[order] / info.fps, command[order], q[order]))
    return tuple(joints), rows


def _check_size(folder: Path, episode: int, frame: np.ndarray, key: str, values: np.ndarray):
    """Refuse positions (n, njoint) that are none in any unit; NaN is nothing that was measured."""
    large = np.isinf(values) | (np.abs(values) > MOST_DEG)
    if large.any():
        row, joint = np.argwhere(large)[0]
        raise RecordingError(
            folder, f"episode {episode}, frame {frame[row]:.0f}, {key}", f"{values[row, joint]:g}",
            f"positions up to {MOST_DEG:.2g}, in whatever unit",
        )  # fmt: skip
