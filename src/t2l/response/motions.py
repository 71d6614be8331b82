"""Commanded and achieved joint positions, of recordings or of a LeRobot data set."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from t2l.errors import RecordingError
from t2l.recordings.checks import ADDED
from t2l.recordings.importers import read_lerobot_positions
from t2l.recordings.log import files, read_recordings
from t2l.recordings.recording import Recording

UNIT = "rad or m"  # of a recording
UNKNOWN = "unit of the data set"


@dataclass(frozen=True)
class Motions:
    """Motions under one controller.

    Attributes:
        label: names them: the gains by the log, or the data set.
        joints: of the columns.
        rows: of each motion its times (n,) s, commands and positions (n, njoint), NaN where not
            measured.
        unit: of commands and positions.
        logged: Kp N·m/rad and Kd N·m·s/rad (njoint,) where a log states them.
    """

    label: str
    joints: tuple[str, ...]
    rows: tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]
    unit: str
    logged: tuple[np.ndarray, np.ndarray] | None = None


def read_motions(
    paths: Sequence[Path],
    joints: Sequence[str] | None = None,
    episodes: Sequence[int] | None = None,
) -> list[Motions]:
    """Motions of recordings and folders of them, one set for each controller, or of a data set.

    Args:
        joints: which of them; by default all.
        episodes: which of a data set's; by default all.

    Raises:
        RecordingError: nothing there, a file is wrong, an unknown joint, or a data set beside
            other paths.
    """
    for path in paths:
        # a recording may be named without the ending of its table
        if not path.exists() and not files(path):
            raise RecordingError(
                path, "the path", "nothing", "a LeRobot data set, a recording or a folder of them"
            )
    sets = [path for path in paths if (path / "meta" / "info.json").is_file()]
    if sets and len(paths) > 1:
        raise RecordingError(sets[0], "the data set", "it beside other paths", "it alone")
    if sets:
        names, parts = read_lerobot_positions(sets[0], joints, episodes)
        return [Motions(sets[0].resolve().name, names, tuple(parts), UNKNOWN)]
    if episodes is not None:
        raise RecordingError(paths[0], "--episodes", "recordings", "a LeRobot data set")
    groups: dict[tuple, list[Recording]] = {}
    for recording in read_recordings(paths):
        gains = tuple(recording.kp), tuple(recording.kd)
        groups.setdefault((recording.robot, recording.joints, *gains), []).append(recording)
    alike = sorted(groups.items(), key=lambda item: (item[0][3], item[0][2]))
    return [_of_recordings(members, joints) for _, members in alike]


def _of_recordings(recordings: Sequence[Recording], joints: Sequence[str] | None) -> Motions:
    first = recordings[0]
    for joint in joints or ():
        if joint not in first.joints:
            raise RecordingError(first.path, "--joints", joint, ", ".join(first.joints))
    chosen = [first.joints.index(joint) for joint in joints or first.joints]
    for recording in recordings:
        _check_position_controlled(recording, chosen)
    rows = tuple((r.time - r.time[0], r.q_des[:, chosen], r.q[:, chosen]) for r in recordings)
    names = tuple(first.joints[j] for j in chosen)
    return Motions(first.cell, names, rows, UNIT, (first.kp[chosen], first.kd[chosen]))


def _check_position_controlled(recording: Recording, chosen: Sequence[int]) -> None:
    """Whether joints follow nothing but their position command.

    Raises:
        RecordingError: one has no stiffness, or a command beside it.
    """
    path = recording.path or recording.name
    if recording.skew[list(chosen)].any():
        allowed = "joints that are measured at the rows' time; see --joints"
        raise RecordingError(path, "key skew_s", "it", allowed)
    for j in chosen:
        joint = recording.joints[j]
        if recording.kp[j] == 0:
            found, allowed = f"joint {joint} with kp 0", "joints with a kp above 0; see --joints"
            raise RecordingError(path, "key kp", found, allowed)
        for name in ADDED:
            values = getattr(recording, name)
            if values is not None and values[:, j].any():
                raise RecordingError(
                    path, f"column {name}.{joint}", "a command beside the position", "0 or no such "
                    "column: gains are told from motions that follow q_des alone"
                )  # fmt: skip
