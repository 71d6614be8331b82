"""Reaching an FR3, or aiofranka's simulation of one."""

import contextlib
import socket
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from t2l.hardware.backend import BackendError

SIMULATION = "simulation"
ADDRESS = f"{SIMULATION}, or the address of an FR3"

# libfranka's command port, and how long a robot in the same network may take to answer there
FCI_PORT, ANSWER_S = 1337, 5.0


def connect(address: str) -> Any:
    """An `aiofranka.Robot`, which nothing drives yet.

    Raises:
        BackendError: the robot cannot be reached.
    """
    if address != SIMULATION:
        _check_answers(address)
    # slow to import, and only needed here
    import aiofranka

    try:
        with _no_viewer():
            return aiofranka.Robot(None if address == SIMULATION else address)
    # libfranka's errors have no common base but Exception
    except Exception as error:
        raise _unreachable(address, " ".join(str(error).split())) from None


def _check_answers(address: str) -> None:
    """Whether a robot listens at an address; libfranka itself waits a minute.

    Raises:
        BackendError: it does not, within `ANSWER_S`.
    """
    try:
        with socket.create_connection((address, FCI_PORT), timeout=ANSWER_S):
            return
    except (OSError, UnicodeError) as error:
        reason = "no answer" if isinstance(error, TimeoutError) else str(error)
        raise _unreachable(address, reason) from None


def _unreachable(address: str, reason: str) -> BackendError:
    return BackendError(
        f"key address: found {address}, which cannot be reached ({reason}); allowed: {ADDRESS} "
        "with FCI active (aiofranka unlock)"
    )


@contextlib.contextmanager
def _no_viewer() -> Iterator[None]:
    """Let aiofranka's simulation do without its window.

    aiofranka 0.9 opens it in `RobotInterface.__init__`, with no argument or setting that says no,
    and fails where there is no display.
    """
    import mujoco.viewer

    launch = mujoco.viewer.launch_passive
    window = SimpleNamespace(sync=lambda: None, close=lambda: None)
    mujoco.viewer.launch_passive = lambda *_, **__: window
    try:
        yield
    finally:
        mujoco.viewer.launch_passive = launch
