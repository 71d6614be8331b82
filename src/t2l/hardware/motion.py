"""The study's identification motion, recorded from a robot."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware.backend import Backend
from t2l.recordings.log import read_recording
from t2l.recordings.recording import Recording
from t2l.robots import Robot

COMMAND_RATE_HZ = 50.0


@dataclass(frozen=True)
class Motion:
    """q_des = q0 + amplitude · sin(π k / 50) at step k of 50 Hz, on all joints: a period of 2 s."""

    amplitude_rad: float
    duration_s: float

    def commands(self, robot: Robot) -> np.ndarray:
        """(ncommand, njoint) rad."""
        k = np.arange(round(self.duration_s * COMMAND_RATE_HZ))
        return robot.home + self.amplitude_rad * np.sin(np.pi * k / 50)[:, None]


def record(arm: Backend, robot: Robot, cell: Cell, motion: Motion, notes: str = "") -> Recording:
    """Measurements at the instants at which commands are given, of the first of `arm`'s robots.

    Raises:
        BackendError: the robot does not go on.
    """
    commands = motion.commands(robot)
    states = [arm.start(robot.home, cell.kp, cell.kd)]
    states += [arm.step(command, 1 / COMMAND_RATE_HZ) for command in commands[:-1]]
    q, dq, tau = (
        np.array([getattr(state, signal)[0] for state in states]) for signal in ("q", "dq", "tau")
    )
    return Recording(
        name=cell.name,
        path=None,
        robot=robot.name,
        joints=robot.joints,
        kp=np.full(len(robot.joints), float(cell.kp)),
        kd=np.full(len(robot.joints), float(cell.kd)),
        command_rate_hz=COMMAND_RATE_HZ,
        control_rate_hz=arm.control_rate_hz,
        gravity_compensation=True,
        time=np.arange(len(commands)) / COMMAND_RATE_HZ,
        q_des=commands,
        q=q,
        dq=dq,
        tau=tau,
        notes=notes,
    )


def recorded(folder: Path | str, robot: Robot, cell: Cell) -> Recording:
    """The recording of a cell in a folder of logs, one file a cell.

    Raises:
        ConfigurationError: its gains are not the cell's, or it is not of the robot's joints.
        RecordingError: the recording cannot be read.
    """
    recording = read_recording(Path(folder) / cell.name)
    if recording.cell != cell.name or recording.joints != robot.joints:
        raise ConfigurationError(
            f"{recording.path}: found {recording.cell} of {', '.join(recording.joints)}; allowed: "
            f"{cell.name} of {', '.join(robot.joints)}"
        )
    return recording


def recorded_path(robot: Mapping[str, Any], cell: str) -> list[str]:
    """Files that the recording of a cell is taken from, if it is: for a workflow to watch."""
    if robot["backend"] != "recorded":
        return []
    stem = Path(robot["recordings"]) / cell
    return [str(path) for path in sorted(stem.parent.glob(f"{cell}.*"))]
