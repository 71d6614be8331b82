"""What robots measure, and what a back end can do with them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np


@dataclass(frozen=True)
class State:
    """What `n` robots measure at an instant; see `SIGNALS`.

    Attributes:
        q, dq: (n, njoint), rad and rad/s.
        tau: (n, njoint) torque that the controller sends, N·m, without gravity compensation; None
            where the robot does not tell.
    """

    q: np.ndarray
    dq: np.ndarray
    tau: np.ndarray | None = None


@dataclass(frozen=True)
class Signal:
    """A part of a `State`, (n, njoint), by its name there and in a recording.

    Attributes:
        name: attribute of `State`.
        unit: of its numbers.
    """

    name: str
    unit: str


POSITION, VELOCITY, TORQUE = Signal("q", "rad"), Signal("dq", "rad/s"), Signal("tau", "N·m")
SIGNALS = (POSITION, VELOCITY, TORQUE)


@dataclass(frozen=True)
class Features:
    """What a back end can do with a robot.

    Attributes:
        control_rate_hz: how often the controller evaluates its law; None where only logs say.
        signals: that are measured, and recorded.
        real_time: whether a period passes by the clock on the wall.
        side_by_side: robots at once, at most; None for as many as memory holds.
        takes_commands: whether it can follow commands, of a motion or a policy.
        logs_cycles: whether it logs every cycle of its controller, see `Backend.log_cycles`.
        gravity_compensation: whether the robot cancels its own gravity, as of `Recording`.
        truth_known: whether `Backend.truth` tells what identification should find.
    """

    control_rate_hz: float | None
    signals: tuple[Signal, ...] = SIGNALS
    real_time: bool = False
    side_by_side: int | None = None
    takes_commands: bool = True
    logs_cycles: bool = False
    gravity_compensation: bool | Literal["continuous"] = True
    truth_known: bool = False
