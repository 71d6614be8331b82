"""Recordings that one batch can hold: their commands at the ticks of one control loop."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from t2l.identify.hidden_state import Beginning
from t2l.identify.initial_state import begins_in_motion, slope_of_motion, start_state
from t2l.identify.noise_floor import noise_floor
from t2l.identify.samples import Samples
from t2l.identify.soft_hold import Gains, soft_hold
from t2l.recordings.checks import ADDED
from t2l.recordings.recording import CONTINUOUS, Recording
from t2l.sim.commands import Stamped
from t2l.sim.schedule import Drive, Hold, Schedule

FOLLOWED = ("supply_voltage", "temperature")  # optional columns that effects may follow


@dataclass(frozen=True)
class Group:
    """Recordings of one loop rate and like length.

    Attributes:
        beginning: of the recordings; None if nothing of it is estimated.
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


def groups(
    recordings: Sequence[Recording],
    samples: Samples,
    coarseness: int,
    in_motion: bool,
    holding: Gains | None = None,
    in_balance: bool = False,
) -> list[Group]:
    """All of `recordings` in groups.

    Args:
        coarseness: real periods from tick to tick.
        in_motion: whether all of them may begin so; else only those may that clearly do.
        holding: of `t2l.identify.soft_hold.hold_gains`.
        in_balance: whether nothing of their beginning is estimated.
    """
    alike = _alike(recordings)
    found = [_group(recordings, samples, each, coarseness, in_motion, holding) for each in alike]
    return [replace(group, beginning=None) for group in found] if in_balance else found


def _alike(recordings: Sequence[Recording]) -> list[list[int]]:
    alike: dict[tuple, list[int]] = {}
    for index, recording in enumerate(recordings):
        # recordings of like length: none waits long for another
        length = round(np.log(max(recording.duration_s, 1e-3)) / np.log(1.5))
        alike.setdefault((recording.control_rate_hz, length), []).append(index)
    return list(alike.values())


def _group(
    every: Sequence[Recording],
    samples: Samples,
    indices: list[int],
    coarseness: int,
    in_motion: bool,
    holding: Gains | None,
) -> Group:
    recordings = [every[i] for i in indices]
    real_period = 1.0 / recordings[0].control_rate_hz
    period = coarseness * real_period
    last = max(int(np.ceil(r.taken_s.max() / period - 1e-6)) for r in recordings)
    ticks, real = np.arange(last + 2), np.arange((last + 2) * coarseness)
    commands = np.empty((len(ticks), len(recordings), len(recordings[0].joints)))
    powered = np.empty_like(commands)
    logged = {name: np.empty_like(commands) for name in FOLLOWED if _all_have(recordings, name)}
    added = {n: np.zeros_like(commands) for n in ADDED if _any_has(recordings, n)}
    supply = np.empty_like(commands)
    for column, recording in enumerate(recordings):
        elapsed = recording.time - recording.time[0]
        row = np.searchsorted(elapsed, real * real_period + 1e-6, side="right") - 1
        columns = [(signal, recording.held(name)) for name, signal in logged.items()]
        columns += [
            (signal, getattr(recording, name))
            for name, signal in added.items()
            if getattr(recording, name) is not None
        ]
        for signal, held in (
            (commands, recording.q_des), (powered, recording.powered), (supply, recording.supply),
            *columns,
        ):  # fmt: skip
            signal[:, column] = held[row].reshape(len(ticks), coarseness, -1).mean(axis=1)
    held = np.flatnonzero(np.isin(samples.recording, indices))
    below, rest = _ticks(samples.time[held], period)
    sample_ticks = np.unique(np.concatenate([[0], below, below + 1]))
    start_q, start_dq = np.moveaxis([start_state(recording) for recording in recordings], 1, 0)
    doubt = np.zeros_like(start_dq)
    moving = np.array([in_motion or begins_in_motion(recording) for recording in recordings])
    for i in np.flatnonzero(moving):
        start_dq[i], doubt[i] = slope_of_motion(recordings[i])
    # that is where the first sample was; some were taken later or earlier
    start_q = start_q - start_dq * [recording.skew for recording in recordings]
    schedule = Schedule(
        period_s=period,
        commands=commands,
        kp=np.array([r.kp for r in recordings]),
        kd=np.array([r.kd for r in recordings]),
        start_q=start_q,
        start_dq=start_dq,
        compensated=np.array([r.gravity_compensation is True for r in recordings]),
        balanced=np.array([r.gravity_compensation == CONTINUOUS for r in recordings]),
        sample_ticks=sample_ticks,
        coarseness=coarseness,
        powered=None if powered.all() else powered,
        clock_s=np.array([r.time[0] for r in recordings]),
        command_period_s=np.array([1 / r.command_rate_hz for r in recordings]),
        logged=logged,
        hold=None if holding is None else _hold(recordings, holding, indices, ticks * period),
        drive=_drive(recordings, supply),
        moving=moving if moving.any() else None,
        stamped=tuple(_stamped(recording, list(added), real_period) for recording in recordings),
        stamped_of=np.arange(len(recordings)),
        **added,
    )
    column = {index: i for i, index in enumerate(indices)}
    record = np.array([column[r] for r in samples.recording[held]])
    wanted = record, np.searchsorted(sample_ticks, below), rest, samples.joint[held]
    noise = max(noise_floor(list(recordings), divided=True), 1e-9)
    beginning = Beginning(schedule, wanted, samples.q[held], noise, doubt)
    return Group(schedule, beginning, tuple(indices), held, wanted)


def _stamped(recording: Recording, added: Sequence[str], period_s: float) -> Stamped:
    signals = {"commands": recording.q_des}
    for name in added:
        given = getattr(recording, name)
        signals[name] = np.zeros_like(recording.q_des) if given is None else given
    return Stamped.of(recording.time - recording.time[0], signals, period_s)


def _drive(recordings: Sequence[Recording], supply: np.ndarray) -> Drive | None:
    if all(recording.motor is None for recording in recordings):
        return None
    stall, back_emf = (np.array([getattr(r, n) for r in recordings]) for n in ("stall", "back_emf"))
    return Drive(stall, back_emf, None if (supply == 1).all() else supply)


def _hold(recordings, holding: Gains, indices: list[int], at: np.ndarray) -> Hold | None:
    if not any(recording.drifts for recording in recordings):
        return None
    return soft_hold(recordings, tuple(gains[indices] for gains in holding), at)


def _any_has(recordings: Sequence[Recording], column: str) -> bool:
    return any(getattr(recording, column) is not None for recording in recordings)


def _all_have(recordings: Sequence[Recording], column: str) -> bool:
    return all(recording.has(column) for recording in recordings)


def _ticks(elapsed: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """The tick at or before each time, and the fraction of a period since it."""
    exact = elapsed / period
    below = np.floor(exact + 1e-6).astype(int)
    rest = np.clip(exact - below, 0.0, None)
    return below, np.where(rest < 1e-6, 0.0, rest)
