"""Which robot a configuration names."""

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from t2l.gains import Cell
from t2l.hardware.backend import Backend
from t2l.hardware.motion import Motion, record, recorded
from t2l.recordings.recording import Recording


def obtain_recording(robot: Mapping[str, Any], cell: Cell, motion: Motion) -> Recording:
    """The identification recording of a cell, from disk or made now.

    Args:
        robot: the `robot` section of a checked configuration.

    Raises:
        T2LError: the robot cannot be reached or used, or a recording cannot be read.
    """
    if robot["backend"] == "recorded":
        return recorded(Path(robot["recordings"]), cell)
    arm = open_robot(robot, 1)
    notes = "the virtual FR3"
    if robot["backend"] == "aiofranka":
        notes = f"aiofranka {version('aiofranka')}, {robot['address']}"
    try:
        return record(arm, cell, motion, notes)
    except BaseException:
        arm.hold()
        raise
    finally:
        arm.close()


def open_robot(robot: Mapping[str, Any], n: int) -> Backend:
    """The robot that a configuration names: `n` virtual ones side by side, or the one of metal.

    Raises:
        BackendError: it cannot be reached.
    """
    # either loads what reading a recording does not need
    if robot["backend"] == "aiofranka":
        from t2l.hardware.franka import FrankaRobot

        return FrankaRobot(robot["address"], "config: robot")
    from t2l.hardware.virtual import VirtualRobot

    return VirtualRobot(n, threads=1)
