"""Which robot a configuration names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from t2l.gains import Cell
from t2l.measurements.recording import Recording
from t2l.sim2real.recording import Motion, record, recorded


def obtain_recording(robot: Mapping[str, Any], cell: Cell, motion: Motion) -> Recording:
    """The identification recording of a cell, from disk or made now.

    Args:
        robot: the `robot` section of a checked configuration.

    Raises:
        T2LError: the robot cannot be reached or used, or a recording cannot be read.
    """
    if robot["backend"] == "recorded":
        return recorded(Path(robot["recordings"]), cell)
    # it loads the simulator, which reading a recording does not need
    from t2l.sim2real.virtual import VirtualRobot

    arm = VirtualRobot(threads=1)
    try:
        return record(arm, cell, motion, "the virtual FR3")
    finally:
        arm.close()
