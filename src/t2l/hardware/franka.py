"""An FR3 under aiofranka's joint impedance controller: of metal by its address, or simulated.

aiofranka's own 1 kHz loop evaluates τ = Kp (q_des − q) − Kd q̇, clamps torques and limits their
rate; here are the motions around it: approach, change of gains, following commands at their rate
under watch, and coming to rest when anything goes wrong.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from functools import wraps
from importlib.metadata import version
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field

from t2l.errors import ConfigurationError
from t2l.hardware.backend import Backend, BackendError
from t2l.hardware.cycles import Cycles
from t2l.hardware.excitation import SMOOTH_STEP_PEAK_VELOCITY, smooth_step
from t2l.hardware.features import Features, State
from t2l.hardware.franka_connection import ADDRESS, SIMULATION, connect
from t2l.robots import Robot, make_robot
from t2l.typed import Typed, refuse

# aiofranka drives this arm and no other
DRIVEN = "fr3"

# aiofranka's torque loop runs at the rate of the robot, and at no other
CONTROL_RATE_HZ = 1000

CAN = Features(CONTROL_RATE_HZ, real_time=True, side_by_side=1, logs_cycles=True)

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

# of every cycle of a recording, and how much longer than it the buffer holds
LOGGED, BUFFER_S = ["time", "q", "dq", "tau", "q_desired"], 60.0


def _address(value: str) -> str:
    if not value.strip() or value != value.strip():
        raise refuse(ADDRESS)
    return value


def _told(method):
    """A method whose errors are `BackendError`."""

    @wraps(method)
    def told(*arguments):
        try:
            return method(*arguments)
        # aiofranka tells of a loop that stopped, or a connection that is lost, by RuntimeError
        except RuntimeError as error:
            raise _stopped(str(error)) from error

    return told


class Settings(Typed):
    """Where the robot is."""

    address: Annotated[str, AfterValidator(_address), Field(description=ADDRESS)]


class AiofrankaRobot(Backend):
    """One started FR3, in real time; `close` holds it where it is, then releases it.

    Attributes:
        controller: aiofranka's.
    """

    name = "aiofranka"
    default_robot = DRIVEN
    settings = Settings
    n = 1

    @classmethod
    def features(cls, robot: Robot, settings: Settings) -> Features:
        """See `Backend.features`."""
        arm = make_robot(DRIVEN)
        if robot.joints != arm.joints:
            raise ConfigurationError(
                f"backend {cls.name}: found the robot {robot.name}; allowed: one of the joints of "
                f"{arm.name}, the only arm that aiofranka drives"
            )
        return CAN

    @classmethod
    def open(cls, robot: Robot, settings: Settings, n: int = 1) -> "AiofrankaRobot":
        """See `Backend.open`."""
        return cls(robot, settings.address)

    @classmethod
    def moves(cls, settings: Settings) -> str:
        """See `Backend.moves`."""
        return "" if settings.address == SIMULATION else f"the FR3 at {settings.address}"

    def __init__(self, robot: Robot, address: str = SIMULATION):
        """Connect and start the control loop.

        Raises:
            BackendError: the robot cannot be reached.
        """
        self.robot, self.can = robot, CAN
        self._arm = connect(address)
        # slow to import, and only needed here
        from aiofranka import Controller

        self.controller: Any = Controller(self._arm)
        try:
            self.controller.start()
        except BaseException as error:
            self.close()
            if isinstance(error, RuntimeError):
                raise _stopped(str(error)) from error
            raise
        self._due = time.perf_counter()
        self.notes = (
            "tau is the torque that was sent, on top of the robot's gravity compensation; "
            f"aiofranka {version('aiofranka')}, {address}"
        )

    @_told
    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """See `Backend.start`; the arm goes there slowly, under gains of its own."""
        start, kp, kd = (self._each(values) for values in (q, kp, kd))
        self._due = time.perf_counter()
        here = self._take_gains(self._each(APPROACH_KP), self._each(APPROACH_KD))
        distance = np.abs(start - here).max()
        duration = max(1.0, SMOOTH_STEP_PEAK_VELOCITY * distance / APPROACH_VELOCITY)
        self._go(_line(here, start, duration), "approach")
        here = self._take_gains(kp, kd)
        hold = np.repeat(start[None], round(SETTLE_S * APPROACH_RATE_HZ), axis=0)
        self._go(np.concatenate([_line(here, start, SETTLE_S), hold]), "settling")
        self._due = time.perf_counter()
        return self.read()

    @property
    def watched_hz(self) -> float:
        """See `Backend.watched_hz`: each cycle, as far as the computer keeps up."""
        return CONTROL_RATE_HZ

    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """See `Backend.send`."""
        for _ in self.sending(q_des, period_s):
            pass

    def sending(self, q_des: np.ndarray, period_s: float) -> Iterator[State]:
        """See `Backend.sending`.

        A command is never sent earlier than a period after the one before: what a stalled computer
        did not send in time comes late, where catching up would make the arm jump. A simulated arm
        that the computer keeps from its cycles gets its commands by these.
        """
        self._give(q_des)
        enough = self._cycles() + HELD * period_s * CONTROL_RATE_HZ
        now = time.perf_counter()
        self._due = due = max(self._due + period_s, now + period_s / 2)
        while now < due or self._cycles() < enough:
            if now > due + LONGEST_STALL_S:
                raise _stopped(f"its control loop stands still for {LONGEST_STALL_S:g} s")
            time.sleep(min(due - now, 1 / CONTROL_RATE_HZ) if now < due else 1 / CONTROL_RATE_HZ)
            yield self.read()
            now = time.perf_counter()

    @_told
    def _give(self, q_des: np.ndarray) -> None:
        self._check_running()
        self.controller.q_desired = self._each(q_des)

    @_told
    def read(self) -> State:
        """See `Backend.read`."""
        self._check_running()
        found = self._arm.state
        values = (found["qpos"], found["qvel"], self.controller.last_command)
        return State(*(np.array(value, float)[None] for value in values))

    @_told
    def log_cycles(self, act: Callable[[], object], duration_s: float) -> Cycles:
        """See `Backend.log_cycles`."""
        # the loop must never wait for its buffer to be emptied
        with self.controller.record(LOGGED, seconds=duration_s + BUFFER_S) as log:
            act()
        if log.dropped:
            raise _stopped(f"{log.dropped} cycles that were not logged")
        found = log.data()
        return Cycles(found["time"], found["q_desired"], {k: found[k] for k in ("q", "dq", "tau")})

    def hold(self) -> None:
        """See `Backend.hold`; a loop that has stopped needs none of it."""
        if not self.controller.running:
            return
        with contextlib.suppress(RuntimeError):
            self._take_gains(self._each(APPROACH_KP), self._each(APPROACH_KD))
            time.sleep(BRAKE_S)
            late = time.perf_counter() + LONGEST_BRAKE_S - BRAKE_S
            while self._moves() and time.perf_counter() < late:
                time.sleep(1 / APPROACH_RATE_HZ)

    @_told
    def close(self) -> None:
        """See `Backend.close`."""
        try:
            self.hold()
        finally:
            self._arm.close()

    def _each(self, values: np.ndarray | float) -> np.ndarray:
        """A number for each joint, (njoint,)."""
        return np.broadcast_to(values, (1, len(self.robot.joints)))[0].astype(float)

    def _take_gains(self, kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """Change gains without a jump: the target becomes the pose, which is returned."""
        self.controller.switch("impedance")
        self.controller.kp, self.controller.kd = kp, kd
        return np.array(self.controller.initial_qpos)

    def _go(self, q_des: np.ndarray, what: str) -> None:
        """Send commands (n, njoint) rad at the rate of approaches, and watch the arm."""
        for command in q_des:
            try:
                for _ in self.watched(command, 1 / APPROACH_RATE_HZ):
                    pass
            except BackendError as error:
                raise BackendError(f"{what}: {error}") from error

    def _moves(self) -> bool:
        speed = np.abs(self._arm.state["qvel"]).max()
        return self.controller.running and speed > RESTING_RAD_S

    @_told
    def _cycles(self) -> int:
        """That the control loop has made since it started."""
        return self.controller.loop_stats()["count"]

    def _check_running(self) -> None:
        """Whether the control loop runs; it stops where a connection is lost."""
        if not self.controller.running:
            fault = self.controller.error or "no error given"
            raise _stopped(f"its control loop has stopped ({fault})")


def _stopped(found: str) -> BackendError:
    return BackendError(f"the robot: found {found}; allowed: a run without errors of the robot")


def _line(start: np.ndarray, end: np.ndarray, duration_s: float) -> np.ndarray:
    """Commands from one pose to another, (n, njoint) rad."""
    n = max(2, round(duration_s * APPROACH_RATE_HZ))
    return start + smooth_step(np.arange(1, n + 1) / n)[:, None] * (end - start)
