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
from t2l.robots.fr3 import JOINTS
from t2l.tasks.reach import CENTRE

COMMAND_RATE_HZ = 50.0


@dataclass(frozen=True)
class Motion:
    """q_des = q0 + amplitude · sin(π k / 50) at step k of 50 Hz, on all joints: a period of 2 s."""

    amplitude_rad: float
    duration_s: float

    def commands(self) -> np.ndarray:
        """(ncommand, 7) rad."""
        k = np.arange(round(self.duration_s * COMMAND_RATE_HZ))
        return np.array(CENTRE) + self.amplitude_rad * np.sin(np.pi * k / 50)[:, None]


def record(robot: Backend, cell: Cell, motion: Motion, notes: str = "") -> Recording:
    """Measurements at the instants at which commands are given, of the first of `robot`'s arms.

    Raises:
        BackendError: the robot does not go on.
    """
    commands = motion.commands()
    states = [robot.start(np.array(CENTRE), cell.kp, cell.kd)]
    states += [robot.step(command, 1 / COMMAND_RATE_HZ) for command in commands[:-1]]
    q, dq, tau = (
        np.array([getattr(state, signal)[0] for state in states]) for signal in ("q", "dq", "tau")
    )
    return Recording(
        name=cell.name,
        path=None,
        robot="fr3",
        joints=JOINTS,
        kp=np.full(len(JOINTS), float(cell.kp)),
        kd=np.full(len(JOINTS), float(cell.kd)),
        command_rate_hz=COMMAND_RATE_HZ,
        control_rate_hz=robot.control_rate_hz,
        gravity_compensation=True,
        time=np.arange(len(commands)) / COMMAND_RATE_HZ,
        q_des=commands,
        q=q,
        dq=dq,
        tau=tau,
        notes=notes,
    )


def recorded(folder: Path | str, cell: Cell) -> Recording:
    """The recording of a cell in a folder of logs, one file a cell.

    Raises:
        ConfigurationError: its gains are not the cell's, or it is not of the FR3's seven joints.
        RecordingError: the recording cannot be read.
    """
    recording = read_recording(Path(folder) / cell.name)
    if recording.cell != cell.name or recording.joints != JOINTS:
        raise ConfigurationError(
            f"{recording.path}: found {recording.cell} of {', '.join(recording.joints)}; allowed: "
            f"{cell.name} of {', '.join(JOINTS)}"
        )
    return recording


def recorded_path(robot: Mapping[str, Any], cell: str) -> list[str]:
    """Files that the recording of a cell is taken from, if it is: for a workflow to watch."""
    if robot["backend"] != "recorded":
        return []
    stem = Path(robot["recordings"]) / cell
    return [str(path) for path in sorted(stem.parent.glob(f"{cell}.*"))]
