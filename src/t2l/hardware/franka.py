"""A real FR3, or aiofranka's simulated one, through the same calls."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from t2l.errors import RecordingError
from t2l.hardware.backend import Backend, BackendError, State
from t2l.hardware.franka_arm import CONTROL_RATE_HZ, FrankaArm
from t2l.hardware.limits import limits_of
from t2l.robots import make_robot


class FrankaRobot(Backend):
    """One FR3 under aiofranka's impedance controller, in real time."""

    n = 1
    control_rate_hz = float(CONTROL_RATE_HZ)

    def __init__(self, address: str, source: Path | str = "robot"):
        """Connect.

        Args:
            address: of the robot, or `simulation`.
            source: of the address, for messages.

        Raises:
            BackendError: it cannot be reached.
        """
        try:
            self._arm = FrankaArm(address, limits_of(make_robot("fr3_hand")), Path(source))
        except RecordingError as error:
            raise BackendError(str(error)) from error
        self._due = time.perf_counter()

    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """See `Backend.start`; the arm goes there slowly, under gains of its own."""
        pose = np.broadcast_to(q, (1, 7))[0]
        gains = (np.broadcast_to(gain, (1, 7))[0].astype(float) for gain in (kp, kd))
        with _backend_errors():
            self._arm.approach(pose, *gains, "deployment")
            self._due = time.perf_counter()
            return self._state()

    def step(self, q_des: np.ndarray, period_s: float) -> State:
        """See `Backend.step`; returns when the period is over.

        A stalled computer makes a command come late, see `FrankaArm.send`.
        """
        with _backend_errors():
            command = np.broadcast_to(q_des, (1, 7))[0].copy()
            self._due = self._arm.send(command, period_s, self._due)
            return self._state()

    def hold(self) -> None:
        """See `Backend.hold`."""
        with _backend_errors():
            self._arm.brake()

    def close(self) -> None:
        """See `Backend.close`."""
        with _backend_errors():
            self._arm.close()

    def _state(self) -> State:
        state = self._arm.watch("deployment")
        tau = self._arm.controller.last_command
        return State(*(np.array(a, float)[None] for a in (state["qpos"], state["qvel"], tau)))


@contextlib.contextmanager
def _backend_errors() -> Iterator[None]:
    try:
        yield
    # aiofranka tells of a loop that stopped, or a connection that is lost, by RuntimeError
    except (RecordingError, RuntimeError) as error:
        raise BackendError(f"the robot: {error}") from error
