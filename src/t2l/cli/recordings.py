"""Writing recordings into a folder, for the commands that import them."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from t2l.errors import ConfigurationError, RecordingError
from t2l.outputs import output_folder
from t2l.recordings.checks import check_against_joint_ranges
from t2l.recordings.log import TABLES, write_recording
from t2l.recordings.recording import Recording
from t2l.registry import python_files
from t2l.robots import plant


def write_recordings(
    recordings: Sequence[Recording], arguments: argparse.Namespace, inputs: Sequence[Path]
) -> None:
    """Write recordings into --out by their names, and print the paths of their tables.

    Raises:
        RecordingError: two have one name, or one is there in the other format.
        OutputError: a recording is there already, or what is read would be replaced.
    """
    folder, format = arguments.out, arguments.format
    _check_ranges(recordings)
    names = [recording.name for recording in recordings]
    for name in names:
        if names.count(name) > 1:
            path = folder / f"{name}.{format}"
            raise RecordingError(path, "the name", "it twice", "tables with different names")
        for suffix in TABLES:
            other = folder / f"{name}{suffix}"
            if suffix != f".{format}" and other.exists():
                raise RecordingError(other, "the folder", "this table", "one table of that name")
    entries = [f"{name}{suffix}" for name in names for suffix in (f".{format}", ".yaml")]
    read = [*inputs, *python_files(arguments.extensions)]
    with output_folder(
        folder, f"t2l {arguments.command}", entries, read, arguments.force, once=True
    ):
        for recording in recordings:
            print(write_recording(recording, folder / recording.name, format))


def _check_ranges(recordings: Sequence[Recording]) -> None:
    """Find positions that the robot's joints cannot take, where the robot can be asked.

    Raises:
        RecordingError: such a position.
    """
    ranges: dict[tuple, np.ndarray | None] = {}
    for recording in recordings:
        robot = recording.robot, recording.joints
        if robot not in ranges:
            ranges[robot] = _ranges(*robot)
        if ranges[robot] is not None:
            check_against_joint_ranges(recording, ranges[robot], recording.joints)


def _ranges(robot: str, joints: tuple[str, ...]) -> np.ndarray | None:
    """(njoint, 2) rad; None of a robot that is not installed here, or has no such joints."""
    try:
        return plant.position_ranges(plant.compiled(plant.load(robot, joints), robot), joints)
    # whoever simulates the recordings is told
    except ConfigurationError:
        return None
