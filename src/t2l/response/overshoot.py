"""Overshoot after steps of the command."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

STANDS_OUT = 8.0  # times the usual change of the command: a step
HOLDS = 0.05  # of a step, by which the command may still change after it
LEAST_HOLD_S = 0.2  # a step says little about the response if another follows sooner
BEFORE = 0.1  # of a step, by which the joint may be off its command before it
CLEAR = 10.0  # times the noise: smaller steps show noise, not overshoot


@dataclass(frozen=True)
class Overshoot:
    """Median over `steps` of how far the motion passes the step's end, relative to its size."""

    fraction: float
    interval: tuple[float, float] | None
    steps: int


def overshoot(
    rows: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
    noise: float,
    rng: np.random.Generator,
) -> Overshoot | None:
    """Of motions by their rows: time s, command and position (n,), NaN where not measured.

    Args:
        noise: RMS of the position's noise.

    Returns:
        None where the commands have no step that is followed by a hold.
    """
    found = [value for time, command, q in rows for value in _each(time, command, q, noise)]
    if not found:
        return None
    interval = None
    if len(found) >= 4:
        drawn = rng.choice(found, (500, len(found)))
        interval = tuple(map(float, np.quantile(np.median(drawn, axis=1), (0.025, 0.975))))
    return Overshoot(float(np.median(found)), interval, len(found))


def _each(time, command, q, noise) -> list[float]:
    change = np.diff(command)
    moving = np.abs(change[change != 0])
    if not len(moving):
        return []
    # where every change is a step, such as in a staircase, the usual one is none
    usual = np.median(np.abs(change))
    steps = 1 + np.flatnonzero(np.abs(change) > max(STANDS_OUT * usual, CLEAR * noise, 1e-9))
    found = []
    for i in steps:
        size = command[i] - command[i - 1]
        left = np.flatnonzero(np.abs(command[i:] - command[i]) > HOLDS * abs(size))
        end = i + left[0] if len(left) else len(command)
        before = q[: i + 1][np.isfinite(q[: i + 1])]
        if time[end - 1] - time[i] < LEAST_HOLD_S or not len(before):
            continue
        if abs(before[-1] - command[i - 1]) > BEFORE * abs(size):
            continue
        past = (q[i:end] - command[i]) / size
        if np.isfinite(past).any():
            found.append(max(0.0, float(np.nanmax(past))))
    return found
