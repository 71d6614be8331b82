"""What a group of recordings asks of a control loop, tick by tick."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from t2l.errors import EffectError
from t2l.sim.commands import Stamped


@dataclass(frozen=True)
class Hold:
    """A weak spring and damper to the measured motion, where no position is commanded.

    It is no torque of the motor: nothing delays, limits or scales it, and a motor that is off
    leaves it on.

    Attributes:
        q, dq: (ntick, nrec, njoint) rad and rad/s, measured.
        kp, kd: (ntick, nrec, njoint) N·m/rad and N·m·s/rad; zero where nothing is held.
    """

    q: np.ndarray
    dq: np.ndarray
    kp: np.ndarray
    kd: np.ndarray

    def torque(self, tick: int, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """N·m (nsim, njoint) from what encoders read, (nsim, njoint) rad and rad/s."""
        nrec, njoint = self.q.shape[1:]
        q, dq = q.reshape(-1, nrec, njoint), dq.reshape(-1, nrec, njoint)
        pull = self.kp[tick] * (self.q[tick] - q) + self.kd[tick] * (self.dq[tick] - dq)
        return pull.reshape(-1, njoint)

    def each(self, change: Callable[[np.ndarray], np.ndarray]) -> "Hold":
        """With each of the arrays changed alike."""
        return Hold(*map(change, (self.q, self.dq, self.kp, self.kd)))


@dataclass(frozen=True)
class Drive:
    """Of motors under a voltage, see `t2l.recordings.motor`.

    Attributes:
        stall: (nrec, njoint) N·m at which what the loop asks for is cut; infinite without motor.
        back_emf: (nrec, njoint) N·m·s/rad; zero without motor.
        supply: (ntick, nrec, njoint) voltage over that for which gains and `stall` are; None for 1.
    """

    stall: np.ndarray
    back_emf: np.ndarray
    supply: np.ndarray | None = None

    def of(self, recordings: np.ndarray) -> "Drive":
        """Of some recordings, (k,) indices."""
        supply = None if self.supply is None else self.supply[:, recordings]
        return Drive(self.stall[recordings], self.back_emf[recordings], supply)

    def give(self, tick: int, torque: np.ndarray) -> None:
        """Change what the loop asks for (nsim, njoint), N·m, to what full duty allows."""
        each = torque.reshape(-1, *self.stall.shape)
        np.minimum(np.maximum(each, -self.stall, out=each), self.stall, out=each)
        if self.supply is not None:
            each *= self.supply[tick]


@dataclass(frozen=True)
class Schedule:
    """What a group of recordings with one loop rate commands and asks for.

    Attributes:
        period_s: the control loop's period, or `coarseness` of them: from tick to tick.
        commands: (ntick, nrec, njoint) q_des at each tick, rad.
        kp, kd: (nrec, njoint), N·m/rad and N·m·s/rad.
        start_q, start_dq: (nrec, njoint), rad and rad/s.
        compensated: (nrec,) bool, whether the loop compensates gravity.
        balanced: (nrec,) bool, whether gravity is compensated continuously, elsewhere.
        sample_ticks: (nsample,) ticks at which the state is wanted, increasing.
        coarseness: periods of the real loop from tick to tick.
        powered: (ntick, nrec, njoint) part of each tick for which the motor is on; None if always.
        clock_s: (nrec,) s, what the logs' clocks show at the first tick; None for zero.
        dq_des, tau_ff: (ntick, nrec, njoint) rad/s and N·m, commanded beside q_des; None for zero.
        elapsed_s: (nrec,) s, time since the start at the first tick; None for zero.
        command_period_s: (nrec,) s, from command to command; None for that of the ticks.
        logged: optional columns that all of the recordings have, (ntick, nrec, njoint) each.
        hold: to the measured motion; None if every joint follows commanded positions.
        drive: of motors under a voltage; None if every drive gives the torque it is asked for.
        moving: (nrec,) bool, which recordings may begin in motion; None if none does.
        stamped, stamped_of: commands with their stamps, and which of them (nrec,) are of each
            recording; None where they are known at ticks alone.
        phase: (nrec, njoint) rad, with which what swings freely begins; None for zero.
    """

    period_s: float
    commands: np.ndarray
    kp: np.ndarray
    kd: np.ndarray
    start_q: np.ndarray
    start_dq: np.ndarray
    compensated: np.ndarray
    balanced: np.ndarray
    sample_ticks: np.ndarray
    coarseness: int = 1
    powered: np.ndarray | None = None
    clock_s: np.ndarray | None = None
    elapsed_s: np.ndarray | None = None
    command_period_s: np.ndarray | None = None
    dq_des: np.ndarray | None = None
    tau_ff: np.ndarray | None = None
    logged: Mapping[str, np.ndarray] = field(default_factory=dict)
    hold: Hold | None = None
    drive: Drive | None = None
    moving: np.ndarray | None = None
    stamped: tuple[Stamped, ...] | None = None
    stamped_of: np.ndarray | None = None
    phase: np.ndarray | None = None

    def of(self, recordings: np.ndarray) -> "Schedule":
        """Of some recordings, (k,) indices."""
        return replace(
            self,
            commands=self.commands[:, recordings],
            kp=self.kp[recordings],
            kd=self.kd[recordings],
            start_q=self.start_q[recordings],
            start_dq=self.start_dq[recordings],
            compensated=self.compensated[recordings],
            balanced=self.balanced[recordings],
            powered=None if self.powered is None else self.powered[:, recordings],
            clock_s=None if self.clock_s is None else self.clock_s[recordings],
            elapsed_s=None if self.elapsed_s is None else self.elapsed_s[recordings],
            command_period_s=None
            if self.command_period_s is None
            else self.command_period_s[recordings],
            dq_des=None if self.dq_des is None else self.dq_des[:, recordings],
            tau_ff=None if self.tau_ff is None else self.tau_ff[:, recordings],
            logged={name: values[:, recordings] for name, values in self.logged.items()},
            hold=None if self.hold is None else self.hold.each(lambda v: v[:, recordings]),
            drive=None if self.drive is None else self.drive.of(recordings),
            moving=None if self.moving is None else self.moving[recordings],
            stamped_of=None if self.stamped_of is None else self.stamped_of[recordings],
            phase=None if self.phase is None else self.phase[recordings],
        )

    @property
    def may_move(self) -> np.ndarray:
        """(nrec,) bool, which recordings may begin in motion."""
        return np.zeros(len(self.kp), bool) if self.moving is None else self.moving

    def column(self, name: str, needed_by: str | None = None) -> np.ndarray | None:
        """An optional column, (ntick, nrec, njoint); None if a recording lacks it.

        Raises:
            EffectError: it does, and an effect `needed_by` cannot do without.
        """
        if needed_by is not None and name not in self.logged:
            raise EffectError(
                f"effect {needed_by}: it follows the column {name}, which a recording lacks; "
                "allowed: recordings that have it"
            )
        return self.logged.get(name)
