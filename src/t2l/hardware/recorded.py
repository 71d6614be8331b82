"""Logs from disk in a robot's place: they are played back, and follow nobody's commands."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware.backend import Backend, BackendError
from t2l.hardware.features import Features, State
from t2l.hardware.motion import Motion
from t2l.recordings.log import files, read_recording
from t2l.recordings.recording import Recording
from t2l.robots import Robot
from t2l.typed import Problem, Typed, describe

FOLDER = "a folder with one recording a cell, such as kp16_kd1.csv with kp16_kd1.yaml"

CAN = Features(control_rate_hz=None, side_by_side=1, takes_commands=False)


class Settings(Typed):
    """Where the logs are."""

    recordings: Annotated[str, Field(min_length=1, description=FOLDER)]


class RecordedRobot(Backend):
    """A folder of logs, one file a cell."""

    name = "recorded"
    settings = Settings

    def __init__(self, robot: Robot, folder: Path | str):
        self.robot, self.can, self.n, self._folder = robot, CAN, 1, Path(folder)
        self._log: Recording | None = None

    @classmethod
    def features(cls, robot: Robot, settings: Settings) -> Features:
        """See `Backend.features`."""
        return CAN

    @classmethod
    def open(cls, robot: Robot, settings: Settings, n: int = 1) -> "RecordedRobot":
        """See `Backend.open`."""
        return cls(robot, settings.recordings)

    @classmethod
    def problems(cls, settings: Settings, cells: Iterable[Cell]) -> list[Problem]:
        """See `Backend.problems`: the folder, or a recording of a cell, is missing."""
        folder = Path(settings.recordings)
        if not os.path.isdir(folder):
            return [Problem("recordings", describe(settings.recordings), FOLDER)]
        missing = [cell.name for cell in cells if not (folder / f"{cell.name}.yaml").is_file()]
        if not missing:
            return []
        more = f" (and {len(missing) - 3} more)" if len(missing) > 3 else ""
        found = f"no {', '.join(missing[:3])} in {folder}{more}"
        return [Problem("recordings", found, "a folder with a recording of every cell")]

    @classmethod
    def sources(cls, settings: Settings, cell: str) -> list[Path]:
        """See `Backend.sources`."""
        return files(Path(settings.recordings) / cell)

    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """Take the log of these gains; it begins where it begins, whatever `q` is.

        Raises:
            ConfigurationError: the log's gains are not these, or it is not of the robot's joints.
            RecordingError: there is no log of these gains, or it cannot be read.
        """
        cell = Cell(float(np.max(kp)), float(np.max(kd)))
        log = read_recording(self._folder / cell.name)
        if log.cell != cell.name or log.joints != self.robot.joints:
            raise ConfigurationError(
                f"{log.path}: found {log.cell} of {', '.join(log.joints)}; allowed: "
                f"{cell.name} of {', '.join(self.robot.joints)}"
            )
        self._log = log
        return self.read()

    def record(self, motion: Motion) -> Recording:
        """The log of the motion's gains as it is, whatever its commands are."""
        self.start(motion.q_des[0], motion.kp, motion.kd)
        return self._log

    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """Never.

        Raises:
            BackendError: always.
        """
        raise BackendError(
            f"backend {self.name}: found a command; allowed: none, as logs are only played back, "
            "for identification; commands need a robot, such as backend virtual"
        )

    def read(self) -> State:
        """Where the log begins."""
        log = self._log
        dq = np.zeros_like(log.q) if log.dq is None else log.dq
        return State(log.q[:1], dq[:1], None if log.tau is None else log.tau[:1])

    def hold(self) -> None:
        """Nothing moves."""

    def close(self) -> None:
        """Nothing to release."""
