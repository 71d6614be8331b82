"""An FR3 under aiofranka's joint impedance controller: of metal by its address, or simulated.

aiofranka's own 1 kHz loop evaluates τ = Kp (q_des − q) − Kd q̇, clamps torques and limits their
rate; here are the motions around it: approach, change of gains, following commands at their rate
under watch, and coming to rest when anything goes wrong.
"""

import contextlib
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.hardware.excitation import SMOOTH_STEP_PEAK_VELOCITY, smooth_step
from t2l.hardware.limits import Limits, check_state

SIMULATION = "simulation"

# aiofranka's torque loop runs at the rate of the robot, and at no other
CONTROL_RATE_HZ = 1000

# libfranka's command port, and how long a robot in the same network may take to answer there
FCI_PORT, ANSWER_S = 1337, 5.0

# to move about and to brake: aiofranka's stiffness, and damping near critical at every joint
APPROACH_KP, APPROACH_KD = 80.0, 16.0
APPROACH_VELOCITY = 0.4  # rad/s
APPROACH_RATE_HZ = 50.0

# to come to rest at the start under gains of one's own
SETTLE_S = 1.0
# to come to rest when a motion is broken off: at least, and at most if some joint still moves
BRAKE_S, LONGEST_BRAKE_S = 0.5, 3.0
RESTING_RAD_S = 0.01
# of a command's period, in cycles of the robot: more would add their jitter to every period
HELD = 0.9
# later than a command's period: a loop that has not made its cycles by then stands still
LONGEST_STALL_S = 5.0


class FrankaArm:
    """A started arm; `close` holds it where it is, then releases it.

    Attributes:
        controller: aiofranka's.
        limits: that the arm must stay in while it moves.
        source: file whose keys messages name.
    """

    def __init__(self, address: str, limits: Limits, source: Path):
        """Connect and start the control loop.

        Raises:
            RecordingError: the robot cannot be reached.
        """
        self.limits, self.source = limits, source
        if address != SIMULATION:
            _check_answers(address, source)
        # slow to import, and only needed here
        import aiofranka

        try:
            with _no_viewer():
                self._robot = aiofranka.Robot(None if address == SIMULATION else address)
        # libfranka's errors have no common base but Exception
        except Exception as error:
            raise _unreachable(source, address, " ".join(str(error).split())) from None
        self.controller: Any = aiofranka.Controller(self._robot)
        try:
            self.controller.start()
        except RuntimeError as error:
            self.close()
            raise _stopped(source, str(error)) from error
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Hold the arm where it is until it rests, then release it."""
        try:
            self.brake()
        finally:
            self._robot.close()

    def brake(self) -> None:
        """Hold the arm where it is until it rests; a loop that has stopped needs none of it."""
        if not self.controller.running:
            return
        with contextlib.suppress(RuntimeError):
            self.take_gains(np.full(7, APPROACH_KP), np.full(7, APPROACH_KD))
            time.sleep(BRAKE_S)
            late = time.perf_counter() + LONGEST_BRAKE_S - BRAKE_S
            while self._moves() and time.perf_counter() < late:
                time.sleep(1 / APPROACH_RATE_HZ)

    def _moves(self) -> bool:
        speed = np.abs(self._robot.state["qvel"]).max()
        return self.controller.running and speed > RESTING_RAD_S

    def take_gains(self, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """Change gains without a jump: the target becomes the pose, which is returned."""
        self.controller.switch("impedance")
        self.controller.kp, self.controller.kd = kp, kd
        return np.array(self.controller.initial_qpos)

    def approach(self, start: np.ndarray, kp: np.ndarray, kd: np.ndarray, what: str) -> None:
        """Go to a pose (7,) rad and come to rest there under gains kp and kd (7,)."""
        here = self.take_gains(np.full(7, APPROACH_KP), np.full(7, APPROACH_KD))
        distance = np.abs(start - here).max()
        duration = max(1.0, SMOOTH_STEP_PEAK_VELOCITY * distance / APPROACH_VELOCITY)
        self.follow(_line(here, start, duration), APPROACH_RATE_HZ, f"{what}, approach")
        here = self.take_gains(kp, kd)
        hold = np.repeat(start[None], round(SETTLE_S * APPROACH_RATE_HZ), axis=0)
        settle = np.concatenate([_line(here, start, SETTLE_S), hold])
        self.follow(settle, APPROACH_RATE_HZ, f"{what}, settling")

    def follow(self, q_des: np.ndarray, rate_hz: float, what: str) -> None:
        """Send commands (n, 7) rad at their rate, and watch the arm.

        Raises:
            RecordingError: the arm left its limits, or its control loop stopped.
        """
        period = 1 / rate_hz
        due = time.perf_counter()
        for row, command in enumerate(q_des):
            due = self.send(command, period, due)
            self.watch(f"{what}, {row * period:.2f} s")

    def send(self, q_des: np.ndarray, period_s: float, due: float) -> float:
        """Send a command (7,) rad and return when its period is over.

        A command is never sent earlier than a period after the one before: what a stalled computer
        did not send in time comes late, where catching up would make the arm jump. A simulated arm
        that the computer keeps from its cycles gets its commands by these.

        Args:
            due: when the command was due, by `time.perf_counter`.

        Returns:
            When the next one is.

        Raises:
            RecordingError: the control loop stands still.
        """
        self.controller.q_desired = q_des
        enough = self._cycles() + HELD * period_s * CONTROL_RATE_HZ
        due = max(due + period_s, time.perf_counter() + period_s / 2)
        time.sleep(max(0.0, due - time.perf_counter()))
        while self.controller.running and self._cycles() < enough:
            if time.perf_counter() > due + LONGEST_STALL_S:
                found = f"a control loop that stands still for {LONGEST_STALL_S:g} s"
                raise _stopped(self.source, found)
            time.sleep(1 / CONTROL_RATE_HZ)
        return due

    def _cycles(self) -> int:
        """That the control loop has made since it started."""
        return self.controller.loop_stats()["count"]

    def watch(self, where: str) -> dict[str, np.ndarray]:
        """The arm's state, if it is within its limits.

        Raises:
            RecordingError: it is not, or the control loop has stopped, as on a lost connection.
        """
        if not self.controller.running:
            fault = self.controller.error or "no error given"
            raise _stopped(self.source, f"{where}: its control loop has stopped ({fault})")
        state = self._robot.state
        check_state(state["qpos"], state["qvel"], self.limits, self.source, where)
        return state


@contextlib.contextmanager
def franka_arm(address: str, limits: Limits, source: Path) -> Iterator[FrankaArm]:
    """An arm, at rest and released again however the block ends.

    Raises:
        RecordingError: the robot cannot be reached, or its loop stopped.
    """
    arm = FrankaArm(address, limits, source)
    try:
        yield arm
    except RuntimeError as error:
        raise _stopped(source, str(error)) from error
    finally:
        arm.close()


def _check_answers(address: str, source: Path) -> None:
    """Whether a robot listens at an address; libfranka itself waits a minute.

    Raises:
        RecordingError: it does not, within `ANSWER_S`.
    """
    try:
        with socket.create_connection((address, FCI_PORT), timeout=ANSWER_S):
            return
    except (OSError, UnicodeError) as error:
        reason = "no answer" if isinstance(error, TimeoutError) else str(error)
        raise _unreachable(source, address, reason) from None


def _unreachable(source: Path, address: str, reason: str) -> RecordingError:
    allowed = f"{SIMULATION}, or the address of an FR3 with FCI active (aiofranka unlock)"
    found = f"{address}, which cannot be reached ({reason})"
    return RecordingError(source, "key address", found, allowed)


def _stopped(source: Path, found: str) -> RecordingError:
    return RecordingError(source, "the robot", found, "a run without errors of the robot")


@contextlib.contextmanager
def _no_viewer() -> Iterator[None]:
    """Let aiofranka's simulation do without the window that it opens unasked."""
    import mujoco.viewer

    class NoViewer:
        def sync(self) -> None: ...

        def close(self) -> None: ...

    launch = mujoco.viewer.launch_passive
    mujoco.viewer.launch_passive = lambda *_, **__: NoViewer()
    try:
        yield
    finally:
        mujoco.viewer.launch_passive = launch


def _line(start: np.ndarray, end: np.ndarray, duration_s: float) -> np.ndarray:
    """Commands from one pose to another, (n, 7) rad."""
    n = max(2, round(duration_s * APPROACH_RATE_HZ))
    return start + smooth_step(np.arange(1, n + 1) / n)[:, None] * (end - start)
