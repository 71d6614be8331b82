"""The YAML of a recording: which robot and joints, under which controller."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.measurements.keys import Keys, describe, suggestion
from t2l.measurements.recording import KNOWN_ROBOTS, Recording

REQUIRED_KEYS = (
    "robot",
    "joints",
    "kp",
    "kd",
    "command_rate_hz",
    "control_rate_hz",
    "gravity_compensation",
)
OPTIONAL_KEYS = ("base_position", "notes")
METADATA_KEYS = (*REQUIRED_KEYS, *OPTIONAL_KEYS)


def check_metadata(values: Any, path: Path) -> dict[str, Any]:
    """The content of a recording's YAML as keyword arguments of `Recording`.

    Args:
        values: what the YAML holds.
        path: the YAML, for messages and for a robot's path relative to it.

    Raises:
        RecordingError: a key is missing, unknown, or of a wrong type, count or sign.
    """
    return metadata_of(Keys(values, path, METADATA_KEYS))


def metadata_of(keys: Keys) -> dict[str, Any]:
    """The same of a mapping that may have further keys.

    Raises:
        RecordingError: a key is missing, or of a wrong type, count or sign.
    """
    robot = _robot(keys)
    joints = keys.names("joints", "joint names, in the order of the columns")
    return {
        "robot": robot,
        "joints": joints,
        "kp": keys.each("kp", len(joints), above=0, unit="N·m/rad"),
        "kd": keys.each("kd", len(joints), at_least=0, unit="N·m·s/rad"),
        "command_rate_hz": keys.number("command_rate_hz", above=0),
        "control_rate_hz": keys.number("control_rate_hz", above=0),
        "gravity_compensation": keys.boolean("gravity_compensation"),
        "base_position": _base_position(keys),
        "notes": keys.text("notes", default=""),
    }


def as_written(recording: Recording, path: Path) -> dict[str, Any]:
    """What the YAML at `path` has to hold."""
    robot = recording.robot
    if robot not in KNOWN_ROBOTS:
        robot = os.path.relpath(robot, path.parent.resolve())
    metadata = {
        "robot": robot,
        "joints": list(recording.joints),
        "kp": _one_or_each(recording.kp),
        "kd": _one_or_each(recording.kd),
        "command_rate_hz": _plain(recording.command_rate_hz),
        "control_rate_hz": _plain(recording.control_rate_hz),
        "gravity_compensation": bool(recording.gravity_compensation),
    }
    if recording.base_position is not None:
        metadata["base_position"] = [float(x) for x in recording.base_position]
    if recording.notes:
        metadata["notes"] = recording.notes
    return metadata


def _one_or_each(gains: np.ndarray) -> float | list[float]:
    each = [_plain(gain) for gain in gains]
    return each[0] if (gains == gains[0]).all() else each


def _plain(number: float) -> float:
    # 64 reads better than 64.0
    return int(number) if float(number).is_integer() else float(number)


def _robot(keys: Keys) -> str:
    allowed = f"{', '.join(KNOWN_ROBOTS)}, or the path of an MJCF file, relative to this YAML"
    value = keys.text("robot", allowed=allowed)
    if value in KNOWN_ROBOTS:
        return value
    model = (keys.path.parent / value).resolve()
    if model.is_file():
        return str(model)
    found = f"{describe(value)}{suggestion(value, KNOWN_ROBOTS)}"
    if value.endswith((".xml", ".mjcf")):
        found = f"{value!r}, but there is no file {model}"
    raise keys.error("robot", found, allowed)


def _base_position(keys: Keys) -> tuple[float, ...] | None:
    if "base_position" not in keys:
        return None
    try:
        return tuple(keys.each("base_position", 3, one_for_all=False).tolist())
    except RecordingError:
        found = describe(keys.values["base_position"])
        raise keys.error("base_position", found, "three numbers, in m") from None
