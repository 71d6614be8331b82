"""What a recording is of: commands, and the gains that they are followed under."""

from dataclasses import dataclass

import numpy as np

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
