"""Recordings that one batch can hold: their commands at the ticks of one control loop."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.identify.hidden_state import WINDOW_S, Beginning
from t2l.identify.initial_state import LEAST_RAD_S, start_state
from t2l.identify.noise_floor import noise_floor
from t2l.identify.samples import Samples
from t2l.recordings.recording import CONTINUOUS, Recording
from t2l.sim.schedule import Schedule

FOLLOWED = ("supply_voltage", "temperature")  # optional columns that effects may follow


@dataclass(frozen=True)
class Group:
    """Recordings of one loop rate and like length.

    Attributes:
        beginning: of the recordings, if any of them begins in motion.
        recordings: indices.
        held: which samples are theirs, (k,) indices.
        wanted: for each of these its recording in the schedule, the index in `sample_ticks` of the
            tick at or before it, the fraction of a period since, and its joint; (k,) each.
    """

    schedule: Schedule
    beginning: Beginning | None
    recordings: tuple[int, ...]
    held: np.ndarray
    wanted: tuple[np.ndarray, ...]


def groups(recordings: Sequence[Recording], samples: Samples, coarseness: int) -> list[Group]:
    """All of `recordings` in groups; `coarseness` real periods from tick to tick."""
    return [_group(recordings, samples, alike, coarseness) for alike in _alike(recordings)]


def _alike(recordings: Sequence[Recording]) -> list[list[int]]:
    alike: dict[tuple, list[int]] = {}
    for index, recording in enumerate(recordings):
        # recordings of like length: none waits long for another
        length = round(np.log(max(recording.duration_s, 1e-3)) / np.log(1.5))
        alike.setdefault((recording.control_rate_hz, length), []).append(index)
    return list(alike.values())


def _group(
    every: Sequence[Recording], samples: Samples, indices: list[int], coarseness: int
) -> Group:
    recordings = [every[i] for i in indices]
    real_period = 1.0 / recordings[0].control_rate_hz
    period = coarseness * real_period
    last = max(int(np.ceil(r.duration_s / period - 1e-6)) for r in recordings)
    ticks, real = np.arange(last + 2), np.arange((last + 2) * coarseness)
    commands = np.empty((len(ticks), len(recordings), len(recordings[0].joints)))
    powered = np.empty_like(commands)
    logged = {name: np.empty_like(commands) for name in FOLLOWED if _all_have(recordings, name)}
    for column, recording in enumerate(recordings):
        elapsed = recording.time - recording.time[0]
        row = np.searchsorted(elapsed, real * real_period + 1e-6, side="right") - 1
        columns = [(signal, recording.held(name)) for name, signal in logged.items()]
        for signal, held in (
            (commands, recording.q_des), (powered, recording.powered), *columns
        ):  # fmt: skip
            signal[:, column] = held[row].reshape(len(ticks), coarseness, -1).mean(axis=1)
    held = np.flatnonzero(np.isin(samples.recording, indices))
    below, rest = _ticks(samples.time[held], period)
    sample_ticks = np.unique(np.concatenate([[0], below, below + 1]))
    start = [start_state(recording) for recording in recordings]
    schedule = Schedule(
        period_s=period,
        commands=commands,
        kp=np.array([r.kp for r in recordings]),
        kd=np.array([r.kd for r in recordings]),
        start_q=np.array([q for q, _ in start]),
        start_dq=np.array([dq for _, dq in start]),
        compensated=np.array([r.gravity_compensation is True for r in recordings]),
        balanced=np.array([r.gravity_compensation == CONTINUOUS for r in recordings]),
        sample_ticks=sample_ticks,
        coarseness=coarseness,
        powered=None if powered.all() else powered,
        clock_s=np.array([r.time[0] for r in recordings]),
        logged=logged,
    )
    column = {index: i for i, index in enumerate(indices)}
    record = np.array([column[r] for r in samples.recording[held]])
    wanted = record, np.searchsorted(sample_ticks, below), rest, samples.joint[held]
    beginning = _beginning(recordings, schedule, wanted, samples.q[held])
    return Group(schedule, beginning, tuple(indices), held, wanted)


def _all_have(recordings: Sequence[Recording], column: str) -> bool:
    return all(recording.has(column) for recording in recordings)


def _beginning(
    recordings: Sequence[Recording], schedule: Schedule, wanted: Sequence, measured: np.ndarray
) -> Beginning | None:
    if (np.abs(schedule.start_dq) <= LEAST_RAD_S).all():
        return None
    last = int(np.ceil(WINDOW_S / schedule.period_s))
    ticks = schedule.sample_ticks[schedule.sample_ticks <= last]
    early = np.flatnonzero(wanted[1] + 1 < len(ticks))
    noise = max(noise_floor(list(recordings)), 1e-9)
    schedule = replace(schedule, sample_ticks=ticks)
    return Beginning(schedule, tuple(w[early] for w in wanted), measured[early], noise)


def _ticks(elapsed: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """The tick at or before each time, and the fraction of a period since it."""
    exact = elapsed / period
    below = np.floor(exact + 1e-6).astype(int)
    rest = np.clip(exact - below, 0.0, None)
    return below, np.where(rest < 1e-6, 0.0, rest)
