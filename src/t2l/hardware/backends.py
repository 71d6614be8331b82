"""Which robot a configuration names."""

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from t2l.gains import Cell
from t2l.hardware.backend import Backend
from t2l.hardware.motion import Motion, record, recorded
from t2l.recordings.recording import Recording
from t2l.robots import Robot


def obtain_recording(
    section: Mapping[str, Any], robot: Robot, cell: Cell, motion: Motion
) -> Recording:
    """The identification recording of a cell, from disk or made now.

    Args:
        section: `robot` of a checked configuration.

    Raises:
        T2LError: the robot cannot be reached or used, or a recording cannot be read.
    """
    if section["backend"] == "recorded":
        return recorded(Path(section["recordings"]), robot, cell)
    arm = open_robot(section, robot, 1)
    notes = f"the virtual {robot.name}"
    if section["backend"] == "aiofranka":
        notes = f"aiofranka {version('aiofranka')}, {section['address']}"
    try:
        return record(arm, robot, cell, motion, notes)
    except BaseException:
        arm.hold()
        raise
    finally:
        arm.close()


def open_robot(section: Mapping[str, Any], robot: Robot, n: int) -> Backend:
    """The robot that a configuration names: `n` virtual ones side by side, or the one of metal.

    Raises:
        BackendError: it cannot be reached.
    """
    # either loads what reading a recording does not need
    if section["backend"] == "aiofranka":
        from t2l.hardware.franka import FrankaRobot

        return FrankaRobot(section["address"], "config: robot")
    from t2l.hardware.virtual import VirtualRobot

    return VirtualRobot(robot, n, threads=1)
