"""What a robot at the other end can do, whichever it is."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from t2l.errors import T2LError


class BackendError(T2LError):
    """The robot refuses a command, cannot be reached, or runs away."""


@dataclass(frozen=True)
class State:
    """What `n` robots measure at an instant.

    Attributes:
        q, dq: (n, 7), rad and rad/s.
        tau: (n, 7) torque that the controller sends, N·m, without gravity compensation.
    """

    q: np.ndarray
    dq: np.ndarray
    tau: np.ndarray


class Backend(ABC):
    """`n` robots under a position controller.

    Attributes:
        n: how many run side by side (one, if it is of metal).
        control_rate_hz: how often the controller evaluates its law.
    """

    n: int
    control_rate_hz: float

    @abstractmethod
    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """Come to rest at q (n, 7) rad under gains kp and kd, which broadcast to (n, 7)."""

    @abstractmethod
    def step(self, q_des: np.ndarray, period_s: float) -> State:
        """Hold the command q_des (n, 7) rad for a period; the state at its end.

        Raises:
            BackendError: the robot does not go on.
        """

    @abstractmethod
    def hold(self) -> None:
        """Come to rest where it is, whatever it was doing; it can be started again."""

    @abstractmethod
    def close(self) -> None:
        """Stop safely and release the robot."""
