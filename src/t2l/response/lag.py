"""How late a motion is behind its commands, by cross-correlation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LONGEST_S = 2.0  # later than any controller answers
SHORTEST_PART = 4  # of a motion, that a lag may be
BLOCK_S = 1.0  # of time, between which a bootstrap draws
RESAMPLES = 500
LEAST_BLOCKS = 4  # for an interval


@dataclass(frozen=True)
class Lag:
    """Lag in s; `interval` is the 95 % block bootstrap, None with too few blocks of time."""

    seconds: float
    interval: tuple[float, float] | None


def lag(
    pairs: Sequence[tuple[np.ndarray, np.ndarray]], period_s: float, rng: np.random.Generator
) -> Lag | None:
    """The shift at which motion and command are most alike, between samples by a parabola.

    Args:
        pairs: command and motion (n,) on one even grid of `period_s`, one of each motion.

    Returns:
        None where nothing moves, or the likeliest shift is the longest that is looked at.
    """
    most = max(len(command) for command, _ in pairs)
    # a parabola needs neighbours on both sides
    shifts = np.arange(-1, int(min(LONGEST_S / period_s, most // SHORTEST_PART)) + 2)
    size = max(1, round(BLOCK_S / period_s))
    products = [
        _products(command - command.mean(), motion - motion.mean(), shifts, size)
        for command, motion in pairs
        if len(command) > SHORTEST_PART * 2 and len(command) > shifts[-1] + 2
    ]
    if not products:
        return None
    products = np.concatenate(products)
    best = _peak(products.sum(axis=0))
    if best is None:
        return None
    interval = None
    if len(products) >= LEAST_BLOCKS:
        drawn = rng.integers(0, len(products), (RESAMPLES, len(products)))
        weights = np.stack([np.bincount(row, minlength=len(products)) for row in drawn])
        peaks = [peak for peak in map(_peak, weights @ products) if peak is not None]
        if len(peaks) > 0.95 * RESAMPLES:
            low, high = np.quantile(peaks, (0.025, 0.975))
            interval = (float(low) * period_s, float(high) * period_s)
    return Lag(best * period_s, interval)


def _products(command, motion, shifts, size) -> np.ndarray:
    """(nblock, nshift) command times shifted motion, summed over blocks of time.

    Only of commands that have their motion at every shift, so that no shift has more of them.
    """
    n = len(command) - shifts[-1] - 1
    starts = np.arange(0, n, size)
    later = np.lib.stride_tricks.sliding_window_view(motion, len(shifts))[:n]
    return np.add.reduceat(command[1 : n + 1, None] * later, starts, axis=0)


def _peak(curve: np.ndarray) -> float | None:
    """The shift, from −1, where a curve is largest; None at the last or if nothing is positive."""
    i = int(np.argmax(curve))
    if i == len(curve) - 1 or not curve[i] > 0:
        return None
    if i == 0:
        return 0.0
    before, at, after = curve[i - 1 : i + 2]
    bend = before - 2 * at + after
    return float(max(i - 1 + (0.5 * (before - after) / bend if bend < 0 else 0.0), 0.0))
