"""What a recording is of: commands, and the gains that they are followed under."""

from dataclasses import dataclass

import numpy as np

from t2l.gains import Cell
from t2l.hardware.excitation import study_sine
from t2l.robots import Robot

COMMAND_RATE_HZ = 50.0


@dataclass(frozen=True, eq=False)
class Motion:
    """Commands at a rate, under gains.

    Attributes:
        name: of the recording.
        q_des: (ncommand, njoint) rad, one every 1/`rate_hz` s.
        rate_hz: of the commands.
        kp, kd: (njoint,) N·m/rad and N·m·s/rad.
        notes: kept with the recording.
    """

    name: str
    q_des: np.ndarray
    rate_hz: float
    kp: np.ndarray
    kd: np.ndarray
    notes: str = ""

    @property
    def time(self) -> np.ndarray:
        """(ncommand,) s, when commands are due."""
        return np.arange(len(self.q_des)) / self.rate_hz

    @property
    def duration_s(self) -> float:
        """Until the last command has been held."""
        return len(self.q_des) / self.rate_hz


def identification_motion(
    robot: Robot, cell: Cell, amplitude_rad: float, duration_s: float
) -> Motion:
    """The study's: a sine of 0.5 Hz about home on all joints, commanded at 50 Hz."""
    offsets = study_sine(round(duration_s * COMMAND_RATE_HZ), amplitude_rad)
    gains = (np.full(len(robot.joints), float(gain)) for gain in (cell.kp, cell.kd))
    return Motion(cell.name, robot.home + offsets, COMMAND_RATE_HZ, *gains)
