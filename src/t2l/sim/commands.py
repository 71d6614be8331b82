"""What is commanded at a tick of a loop: commands late or early by a time, between their stamps.

A command takes effect at the first tick after it arrives. So where commands are stamped at any time
between ticks, as a computer's are that talks to a drive, how late each becomes differs from one to
the next, and only its own stamp tells. Where those of all recordings are stamped at ticks, nothing
tells what a part of a tick does; there a signal is linear from tick to tick.

As a delay grows, one command after the other misses its tick, so that a loop jumps with it. What
asks for derivatives is given those of the mean over a tick.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

WHOLE = 1e-9  # numerics: of a tick, that is none
AT_A_TICK_S = 1e-6  # numerics: a stamp so little later than a tick is at it
AT_ONCE = 128  # numerics: ticks that are looked up at once


@dataclass(frozen=True)
class Stamped:
    """Commands of a recording as they were logged, each held until the next.

    Attributes:
        elapsed_s: (n,) since the first tick.
        values: (n, njoint) by name of the field of a `Schedule`.
        period_s: of the loop.
        at_ticks: whether all are stamped at ticks.
    """

    elapsed_s: np.ndarray
    values: dict[str, np.ndarray]
    period_s: float
    at_ticks: bool

    @classmethod
    def of(cls, elapsed_s: np.ndarray, values: dict[str, np.ndarray], period_s: float) -> "Stamped":
        """Of rows of which those count that command something new."""
        every = np.hstack(list(values.values()))
        new = np.r_[True, (np.diff(every, axis=0) != 0).any(axis=1)]
        elapsed_s = elapsed_s[new]
        off = np.abs(elapsed_s - period_s * np.round(elapsed_s / period_s))
        kept = {name: value[new] for name, value in values.items()}
        return cls(elapsed_s, kept, period_s, bool((off <= AT_A_TICK_S).all()))

    def at(self, name: str, at_s: np.ndarray) -> np.ndarray:
        """Commands (..., njoint) in force at some times (...,) since the first tick."""
        return self.values[name][self._row(at_s)]

    def mean(self, name: str, at_s: np.ndarray) -> np.ndarray:
        """The same on average over a tick with these times in its middle."""
        half = 0.5 * self.period_s
        return (self._sum(name, at_s + half) - self._sum(name, at_s - half)) / self.period_s

    def smooth(self, name: str, at_s: np.ndarray, lead_s: float) -> np.ndarray:
        """The same as `at`, with a derivative: that of the mean, from a lead that is near.

        Args:
            lead_s: that the times have.
        """
        step = 0.5 * self.period_s
        near = at_s + step * np.round(lead_s / step) - lead_s
        return self.at(name, near) + self.mean(name, at_s) - self.mean(name, near)

    def _sum(self, name: str, until_s: np.ndarray) -> np.ndarray:
        row = self._row(until_s)
        since = (until_s - self.elapsed_s[row])[..., None]
        return self._passed[name][row] + self.values[name][row] * since

    @cached_property
    def _passed(self) -> dict[str, np.ndarray]:
        """By name the integral (n, njoint) of what was commanded until each stamp."""
        held_s = np.diff(self.elapsed_s, prepend=self.elapsed_s[0])[:, None]
        return {
            name: np.cumsum(held_s * np.concatenate([values[:1], values[:-1]]), axis=0)
            for name, values in self.values.items()
        }

    def _row(self, at_s: np.ndarray) -> np.ndarray:
        row = np.searchsorted(self.elapsed_s, at_s + AT_A_TICK_S, side="right") - 1
        return np.maximum(row, 0)


def commands(name: str, loop, smooth: bool = False) -> Callable[[int | np.ndarray], np.ndarray]:
    """What is commanded (nsim, njoint) at a tick, or (k, nsim, njoint) at several, unfiltered.

    Args:
        name: `commands`, `dq_des` or `tau_ff` of the loop's schedule.
        loop: whose `schedule`, `recording`, `command_lead_s` and `command_delay_s` count.
        smooth: whether a delay is to have a derivative.
    """
    schedule, recording = loop.schedule, loop.recording
    given, lead_s = getattr(schedule, name), loop.command_lead_s - loop.command_delay_s
    if not lead_s.any():
        return lambda tick: given[tick].take(recording, axis=-2)
    if schedule.stamped is None:
        return _from_tick_to_tick(given, recording, lead_s / loop.period_s)
    # ticks in no order do not tell what was commanded before them
    in_order = schedule.elapsed_s is None
    at_ticks = all(one.at_ticks for one in schedule.stamped)
    if in_order and at_ticks:
        at = _from_tick_to_tick(given, recording, lead_s / loop.period_s)
    else:
        at = _by_stamps(name, loop, at_ticks, smooth)
    return _ahead_of_ticks(at, len(given))


def _from_tick_to_tick(given: np.ndarray, recording: np.ndarray, lead: np.ndarray) -> Callable:
    """Signals (ntick, nrec, njoint) early by `lead` (nsim, njoint) ticks, linear between two."""
    whole = np.floor(lead + WHOLE).astype(int)
    part, last, joint = lead - whole, len(given) - 1, np.arange(given.shape[2])

    def at(tick: int | np.ndarray) -> np.ndarray:
        first = whole + np.asarray(tick)[..., None, None]
        now, next = (
            given[np.minimum(np.maximum(first + n, 0), last), recording[:, None], joint]
            for n in (0, 1)
        )
        return now + part * (next - now)

    return at


def _by_stamps(name: str, loop, at_ticks: bool, smooth: bool) -> Callable:
    """Commands that are delayed by their stamps, others by ticks.

    Args:
        at_ticks: whether all are stamped at ticks.
    """
    schedule, recording, delay_s = loop.schedule, loop.recording, loop.command_delay_s
    lead_s, of = loop.command_lead_s - delay_s, schedule.stamped_of[recording]
    early = loop.command_lead_s / loop.period_s
    in_time = _from_tick_to_tick(getattr(schedule, name), recording, early)
    began = (
        np.zeros(len(recording)) if schedule.elapsed_s is None else schedule.elapsed_s[recording]
    )
    # a tick of several periods has the mean of theirs
    within = np.arange(schedule.coarseness) * loop.real_period_s

    def at(ticks: np.ndarray) -> np.ndarray:
        found = in_time(ticks)
        for lead in np.unique(lead_s[delay_s != 0]):
            moved = (lead_s == lead) & (delay_s != 0)
            for i, stamped in enumerate(schedule.stamped):
                some = np.flatnonzero(moved.any(axis=1) & (of == i))
                at_s = ticks[:, None, None] * loop.period_s + began[some, None] + within + lead
                if at_ticks:  # linear from tick to tick
                    values = stamped.mean(name, at_s + 0.5 * stamped.period_s)
                elif smooth:
                    values = stamped.smooth(name, at_s, lead)
                else:
                    values = stamped.at(name, at_s)
                values = values.mean(axis=2)
                found[:, some] = np.where(moved[some], values, found[:, some])
        return found

    return at


def _ahead_of_ticks(at: Callable, ntick: int) -> Callable:
    """The same, looked up for some ticks at once, also where they are asked for one by one."""
    known: dict[int, np.ndarray] = {}

    def looked_up(tick: int | np.ndarray) -> np.ndarray:
        if np.ndim(tick):
            return at(tick)
        if tick not in known:
            known.clear()
            ticks = np.arange(tick, min(tick + AT_ONCE, ntick))
            known.update(zip(ticks.tolist(), at(ticks), strict=True))
        # effects change it in place
        return known[tick].copy()

    return looked_up


def feed_forward(loop, smooth: bool = False) -> Callable[[int], np.ndarray] | None:
    """Kd dq_des + tau_ff (nsim, njoint), N·m, that arrives at a tick; None without such commands.

    Args:
        loop: a `ServoLoop` or what stands for one; its Kd counts as effects left it.
        smooth: as of `commands`.
    """
    velocity, torque = (
        None if getattr(loop.schedule, name) is None else commands(name, loop, smooth)
        for name in ("dq_des", "tau_ff")
    )
    if velocity is None and torque is None:
        return None

    def at(tick: int) -> np.ndarray:
        total = np.zeros_like(loop.kp) if torque is None else torque(tick)
        if velocity is not None:
            total += loop.kd * velocity(tick)
        for change in loop.feed_forward_filters:
            change(tick, total)
        return total

    return at
