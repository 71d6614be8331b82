"""One run of a machine: what was commanded, what was measured."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from t2l.gains import Cell
from t2l.recordings.control import CONTROLS, POSITION, Control

if TYPE_CHECKING:
    from t2l.recordings.motor import Motor

CONTINUOUS = "continuous"
SIGNALS = (
    "time", "q_des", "dq_des", "tau_ff", "q", "dq", "tau", "current", "supply_voltage",
    "temperature", "torque_enabled",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Recording:
    """Commands and measurements over time, with the controller that ran.

    Its law is τ = Kp (q_des − q) + Kd (dq_des − q̇) + tau_ff, with zero for a command that is None.

    Attributes:
        name: the file's name without its ending.
        path: the table it was read from; None while it exists in memory only.
        robot: a name of `t2l.robots.ROBOTS`, or the absolute path of an MJCF file.
        joints: names, in the order of every array's columns.
        kp: N·m/rad, (njoint,); zero for a joint that no command of position moves.
        kd: N·m·s/rad, (njoint,).
        command_rate_hz: how often the commanded positions change.
        control_rate_hz: how often the controller evaluates its law.
        gravity_compensation: whether the machine cancels gravity itself: True if its control loop
            does so at its ticks, `CONTINUOUS` if springs or a much faster loop do.
        time: s, (n,), strictly increasing; gaps are allowed.
        q_des: rad, (n, njoint), each row held until the next; the last measured position where no
            position is commanded, so that it pulls at nothing.
        q: rad, (n, njoint), NaN where not sampled.
        dq_des: rad/s, as q_des; None if velocities are not commanded.
        tau_ff: N·m, as q_des; None if no torque is fed forward.
        dq: rad/s, as q; None if never recorded.
        tau: N·m, as q; None if never recorded.
        current: A, of the motors, as q; None if never recorded.
        supply_voltage: V, as q; None if never recorded.
        temperature: °C, of the motors, as q; None if never recorded.
        torque_enabled: 1 where the motor is on and 0 where it is off, as q but held until the next
            one; None if it was on throughout.
        control: what is commanded, one of `t2l.recordings.control.CONTROLS`.
        motor: of a drive under a voltage, at which `kp`, `kd` and `tau_ff` are what its duty is in
            N·m at `Motor.supply`; None for one that gives the torque it is asked for.
        skew_s: s, (njoint,), by how much later than its row's time what is measured of a joint was
            taken; None for zero.
        base_position: m, (3,), of the robot's base in the world of its model.
        notes: anything a person wants to remember.
    """

    name: str
    path: Path | None
    robot: str
    joints: tuple[str, ...]
    kp: np.ndarray
    kd: np.ndarray
    command_rate_hz: float
    control_rate_hz: float
    gravity_compensation: bool | Literal["continuous"]
    time: np.ndarray
    q_des: np.ndarray
    q: np.ndarray
    dq_des: np.ndarray | None = None
    tau_ff: np.ndarray | None = None
    dq: np.ndarray | None = None
    tau: np.ndarray | None = None
    current: np.ndarray | None = None
    supply_voltage: np.ndarray | None = None
    temperature: np.ndarray | None = None
    torque_enabled: np.ndarray | None = None
    control: str = POSITION
    motor: "Motor | None" = None
    skew_s: np.ndarray | None = None
    base_position: tuple[float, ...] | None = None
    notes: str = ""

    @property
    def by(self) -> Control:
        """What belongs to its kind of control."""
        return CONTROLS[self.control]

    @property
    def drifts(self) -> bool:
        """Whether no position is commanded, so that a free simulation drifts away."""
        return self.control != POSITION

    @property
    def duration_s(self) -> float:
        """From the first row to the last."""
        return float(self.time[-1] - self.time[0])

    def one_row_a_stamp(self) -> "Recording":
        """Of rows in turn that have the same time, one: of each column the last value counts."""
        last = np.append(np.diff(self.time) != 0, True)
        if last.all():
            return self
        ends = np.flatnonzero(last)
        starts = np.append(0, ends[:-1] + 1)

        def latest(values: np.ndarray) -> np.ndarray:
            rows = np.arange(len(values))[:, None]
            given = np.maximum.accumulate(np.where(np.isnan(values), -1, rows))[ends]
            here = given >= starts[:, None]
            return np.where(here, np.take_along_axis(values, np.maximum(given, 0), axis=0), np.nan)

        kept = {name: getattr(self, name) for name in SIGNALS if name != "time"}
        kept = {name: None if values is None else latest(values) for name, values in kept.items()}
        return replace(self, time=self.time[ends], **kept)

    def from_row(self, first: int) -> "Recording":
        """Without the rows before one; whether a motor is on stays as it was."""
        values = {name: getattr(self, name) for name in SIGNALS}
        if self.torque_enabled is not None:
            values["torque_enabled"] = self.powered
        return replace(self, **{n: None if v is None else v[first:] for n, v in values.items()})

    def beginning(self, duration_s: float) -> "Recording":
        """The rows before `duration_s`."""
        return self.part(0.0, duration_s)

    def part(self, begin_s: float, end_s: float) -> "Recording":
        """The rows from `begin_s` on and before `end_s`, by the time since the first."""
        elapsed = self.time - self.time[0]
        rows = (elapsed >= begin_s) & (elapsed < end_s)
        values = {name: getattr(self, name) for name in SIGNALS}
        return replace(self, **{n: None if v is None else v[rows] for n, v in values.items()})

    @property
    def feed_forward(self) -> np.ndarray:
        """(n, njoint) N·m that the loop adds whatever it measures, Kd dq_des + tau_ff."""
        torque = np.zeros_like(self.q_des)
        if self.dq_des is not None:
            torque += self.kd * self.dq_des
        if self.tau_ff is not None:
            torque += self.tau_ff
        return torque

    @property
    def back_emf(self) -> np.ndarray:
        """(njoint,) N·m·s/rad by which motors damp while they are on."""
        return np.zeros(len(self.joints)) if self.motor is None else self.motor.back_emf

    @property
    def stall(self) -> np.ndarray:
        """(njoint,) N·m at which full duty cuts what the loop asks for; infinite without motor."""
        return np.full(len(self.joints), np.inf) if self.motor is None else self.motor.stall

    @property
    def supply(self) -> np.ndarray:
        """(n, njoint) supply voltage over that for which the gains are."""
        if self.motor is None or not self.motor.logged:
            return np.ones_like(self.q_des)
        return self.held("supply_voltage") / self.motor.supply

    def measured(self, joint: int) -> tuple[np.ndarray, np.ndarray]:
        """Times since the start, s, and positions, rad, of the samples of a joint; (k,) each."""
        rows = np.flatnonzero(~np.isnan(self.q[:, joint]))
        return self.taken_s[rows, joint], self.q[rows, joint]

    @property
    def skew(self) -> np.ndarray:
        """(njoint,) s of `skew_s`, zero where it is None."""
        return np.zeros(len(self.joints)) if self.skew_s is None else self.skew_s

    @property
    def taken_s(self) -> np.ndarray:
        """(n, njoint) s since the first row, when what is measured was taken."""
        return (self.time - self.time[0])[:, None] + self.skew

    @property
    def powered(self) -> np.ndarray:
        """(n, njoint), 1.0 where the motor is on and 0.0 where it is off."""
        if self.torque_enabled is None:
            return np.ones_like(self.q_des)
        known = ~np.isnan(self.torque_enabled)
        return np.where(np.maximum.accumulate(known), self.held("torque_enabled"), 1.0)

    def has(self, column: str) -> bool:
        """Whether every joint has a sample of an optional column."""
        values = getattr(self, column)
        return values is not None and bool((~np.isnan(values)).any(axis=0).all())

    def held(self, column: str) -> np.ndarray:
        """(n, njoint) of an optional column, each sample held until the next.

        Before the first sample it is the first; NaN where a joint has none.
        """
        return held(getattr(self, column))

    @property
    def cell(self) -> str:
        """``kp64_kd4`` where every joint has the same gains, else the recording's name."""
        kp, kd = self.kp[0], self.kd[0]
        # no cell has a gain of zero, but a recording may
        if (self.kp != kp).any() or (self.kd != kd).any() or min(kp, kd) <= 0:
            return self.name
        return Cell(kp=float(kp), kd=float(kd)).name


def held(values: np.ndarray) -> np.ndarray:
    """(n, njoint) of which each is held until the next that is not NaN, as `Recording.held`."""
    known = ~np.isnan(values)
    last = np.maximum.accumulate(np.where(known, np.arange(len(known))[:, None], 0))
    last = np.maximum(last, np.argmax(known, axis=0))
    return np.take_along_axis(values, last, axis=0)
