"""What a robot at the other end can do, whichever it is.

    with find_backend("virtual").open(robot, settings) as arm:
        state = arm.start(q, kp, kd)
        arm.send(q_des, 0.02)
        state = arm.read()

Whatever the back end, `record` watches what is measured while a command is held, as often as
`sending` shows it. A joint beyond a limit of the robot ends the motion: the robot is held, and an
error says which joint, what was measured and what is allowed.

A back end of your own is a class that derives from `Backend`, in a file under `extensions`.
"""

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from t2l.errors import T2LError
from t2l.gains import Cell
from t2l.hardware.cycles import Cycles, rows_of_commands
from t2l.hardware.features import Features, State
from t2l.hardware.limits import GENTLER, state_objections
from t2l.hardware.motion import Motion
from t2l.recordings.recording import Recording
from t2l.robots import Robot
from t2l.typed import Problem, Typed

# of a back end in real time that does not say better: a command each time costs it little
WATCHED_HZ = 100.0


class BackendError(T2LError):
    """The robot refuses a command, cannot be reached, or has left its limits."""


class BeyondLimitError(BackendError):
    """A joint was measured beyond a limit, and the robot was stopped."""


class PositionControlled(ABC):
    """`n` robots under a position controller, τ = Kp (q_des − q) − Kd q̇.

    Attributes:
        n: how many run side by side (one, if it is of metal).
    """

    n: int

    @abstractmethod
    def start(self, q: np.ndarray, kp: np.ndarray, kd: np.ndarray) -> State:
        """Come to rest at q rad under gains kp N·m/rad and kd N·m·s/rad.

        Args:
            q, kp, kd: each broadcasts to (n, njoint).

        Raises:
            BackendError: the robot does not come there.
        """

    @abstractmethod
    def send(self, q_des: np.ndarray, period_s: float) -> None:
        """Hold the command q_des (n, njoint) rad for a period, and return when it is over.

        It acts when the robot's own latency has passed, be that of a process, a network or a
        controller.

        Raises:
            BackendError: the robot does not go on.
        """

    @abstractmethod
    def read(self) -> State:
        """What is measured now.

        Raises:
            BackendError: the robot does not answer.
        """

    @property
    @abstractmethod
    def watched_hz(self) -> float:
        """How often `sending` shows what is measured."""

    def sending(self, q_des: np.ndarray, period_s: float) -> Iterator[State]:
        """Hold a command as `send` does, and show what is measured meanwhile, at least once.

        By default `send` is given the same command again for each part of the period. A back end
        that can look while it waits says how here.

        Raises:
            BackendError: the robot does not go on.
        """
        parts = max(1, round(period_s * self.watched_hz))
        for _ in range(parts):
            self.send(q_des, period_s / parts)
            yield self.read()

    @abstractmethod
    def hold(self) -> None:
        """Come to rest where it is, whatever it was doing; it can be started again."""

    @abstractmethod
    def close(self) -> None:
        """Stop safely and release the robot."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_) -> None:
        self.close()


class Backend(PositionControlled):
    """A way to robots, by the name that configurations give under `backend`.

    Attributes:
        name: what configurations write.
        default_robot: name of the robot that it drives where none is named; "" for none.
        settings: its own keys in a configuration; none by default.
        robot: that it drives.
        can: what it can do with it.
        notes: kept with every recording.
    """

    name: ClassVar[str]
    default_robot: ClassVar[str] = ""
    settings: ClassVar[type[Typed]] = Typed
    robot: Robot
    can: Features
    notes: str = ""

    @classmethod
    @abstractmethod
    def features(cls, robot: Robot, settings: Any) -> Features:
        """What it can do with a robot.

        Args:
            settings: an instance of the class's `settings`.

        Raises:
            ConfigurationError: it does not drive such a robot.
        """

    @classmethod
    @abstractmethod
    def open(cls, robot: Robot, settings: Any, n: int = 1) -> Self:
        """Connect to `n` robots.

        Args:
            settings: an instance of the class's `settings`.

        Raises:
            BackendError: they cannot be reached.
        """

    @classmethod
    def moves(cls, settings: Any) -> str:
        """What of metal will move, in words, for a person to agree; "" if nothing will."""
        return ""

    @classmethod
    def problems(cls, settings: Any, cells: Iterable[Cell]) -> list[Problem]:
        """What is wrong with settings that are well written, found before any job starts."""
        return []

    @classmethod
    def sources(cls, settings: Any, cell: str) -> list[Path]:
        """Files that the recording of a cell is taken from, for a workflow to watch."""
        return []

    @classmethod
    def truth(cls, robot: Robot, settings: Any) -> Mapping[str, np.ndarray]:
        """What is true of a robot that is a simulation; for reports, and for nothing that fits.

        Only of a back end whose features say that it is known.

        Returns:
            (njoint,) each: `armature` kg·m², `sliding_friction` and `breakaway` N·m,
            `viscous_friction` N·m·s/rad, and `torque_scale`, delivered over commanded torque.
        """
        raise NotImplementedError

    def log_cycles(self, act: Callable[[], object], duration_s: float) -> Cycles:
        """Every cycle of the controller while `act` runs, for about `duration_s`.

        Only of a back end whose features say that it logs them.
        """
        raise NotImplementedError

    @property
    def watched_hz(self) -> float:
        """See `PositionControlled.watched_hz`: every tick of the controller, or `WATCHED_HZ`."""
        return WATCHED_HZ if self.can.real_time else float(self.can.control_rate_hz)

    def watched(self, q_des: np.ndarray, period_s: float) -> Iterator[State]:
        """`sending` under watch.

        Raises:
            BackendError: the robot does not go on.
            BeyondLimitError: a joint is measured beyond a limit; the caller brings it to rest.
        """
        for state in self.sending(q_des, period_s):
            measured = {s.name: getattr(state, s.name) for s in self.can.signals}
            for objection in state_objections(self.robot, **measured):
                _stop_for(objection)
            yield state

    def record(self, motion: Motion) -> Recording:
        """Make a motion, and what was measured at the instants at which commands were given.

        Of a back end that logs every cycle these are the cycles that first used a command, which
        say when it acted and not when it was sent. Of several robots the first is recorded.
        Whatever breaks a motion off, the robot is held where it is.

        Raises:
            BackendError: the robot does not go on; the message says when.
            BeyondLimitError: a joint was measured beyond a limit; likewise.
        """
        try:
            self.start(motion.q_des[0], motion.kp, motion.kd)
            if not self.can.logs_cycles:
                rows = Cycles(motion.time, motion.q_des, self._follow(motion))
            else:
                log = self.log_cycles(lambda: self._follow(motion), motion.duration_s)
                # also what fell between two looks
                objections = state_objections(self.robot, **log.measured)
                for time, objection in zip(log.time, objections, strict=True):
                    with _at(motion, lambda time=time: time):
                        _stop_for(objection)
                held = round(self.can.control_rate_hz / motion.rate_hz)
                rows = log.at(rows_of_commands(log.q_des, held))
        except BaseException:
            with contextlib.suppress(BackendError):
                self.hold()
            raise
        return self._recording(motion, rows)

    def _follow(self, motion: Motion) -> dict[str, np.ndarray]:
        """(ncommand, njoint) of each signal, measured when each command was given."""
        states, period_s, time = [], 1 / motion.rate_hz, 0.0
        with _at(motion, lambda: time):
            for begun, command in zip(motion.time, motion.q_des, strict=True):
                time = begun
                states.append(self.read())
                commands = np.broadcast_to(command, (self.n, len(command)))
                looks = self.watched(commands, period_s)
                # when the next is due, which may be the one that stops the robot
                time = begun + min(1 / self.watched_hz, period_s)
                for look, _ in enumerate(looks, 2):
                    time = begun + min(look / self.watched_hz, period_s)
        return {
            signal.name: np.array([getattr(state, signal.name)[0] for state in states])
            for signal in self.can.signals
        }

    def _recording(self, motion: Motion, rows: Cycles) -> Recording:
        return Recording(
            name=motion.name,
            path=None,
            robot=self.robot.name,
            joints=self.robot.joints,
            kp=motion.kp,
            kd=motion.kd,
            command_rate_hz=motion.rate_hz,
            control_rate_hz=float(self.can.control_rate_hz),
            gravity_compensation=self.can.gravity_compensation,
            time=rows.time,
            q_des=rows.q_des,
            notes="; ".join(filter(None, (motion.notes, self.notes))),
            **rows.measured,
        )


def _stop_for(objection: str) -> None:
    if objection:
        raise BeyondLimitError(f"the robot was stopped: found {objection}; {GENTLER}")


@contextlib.contextmanager
def _at(motion: Motion, time_s: Callable[[], float]) -> Iterator[None]:
    """Let an error say in which motion it came, and when."""
    try:
        yield
    except BackendError as error:
        kind = BeyondLimitError if isinstance(error, BeyondLimitError) else BackendError
        raise kind(f"{motion.name}, {time_s():.2f} s: {error}") from error
