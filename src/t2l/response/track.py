"""One joint's commands and motion on an even grid, and what a second-order system makes of them.

The states at the grid's instants are exact (the system's own step response, not an integrator), so
commands may change at any rate.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

FINER = 8  # grid periods in a row's, where the rows are not evenly spaced
EVEN = 1e-3  # of a row's period


@dataclass(frozen=True)
class Track:
    """One joint of one motion on an even grid of `period_s`.

    Attributes:
        command: (n,) at the grid's instants, held to the next.
        at: (m,) measured instants in grid periods since the start; q: (m,) there.
    """

    period_s: float
    command: np.ndarray
    at: np.ndarray
    q: np.ndarray

    @classmethod
    def of(cls, time: np.ndarray, q_des: np.ndarray, q: np.ndarray) -> "Track":
        """Of rows: time (n,) s, increasing; commands and positions (n,), NaN if not measured."""
        steps, elapsed = np.diff(time), time - time[0]
        row = float(np.median(steps))
        multiples = steps / row
        even = np.abs(multiples - np.round(multiples)).max() < EVEN
        period = row if even else row / FINER
        n = int(np.ceil(elapsed[-1] / period - EVEN)) + 1
        held = np.searchsorted(elapsed, np.arange(n) * period + EVEN * period, side="right") - 1
        measured = np.isfinite(q)
        at = elapsed[measured] / period
        return cls(period, q_des[held], np.round(at) if even else at, q[measured])


def respond(
    track: Track, omega: float, zeta: float, delay_s: float = 0.0, rest: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motion (m,) at a track's measured instants.

    Returns:
        The response to the commands less `rest` from rest at zero, and the free motions from
        position 1 at rest and from zero with velocity `omega`.
    """
    h, n = track.period_s, len(track.command)
    system = np.array([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]])
    whole, part = divmod(delay_s / h, 1.0)
    whole = int(whole)
    late = _hold(system, omega, (1 - part) * h)
    # the older command acts for the first part of a period
    early = expm(system * (1 - part) * h) @ _hold(system, omega, part * h)
    command = np.concatenate([np.full(whole + 1, track.command[0]), track.command])[: n + 1] - rest
    forcing = np.outer(early, command[:n]) + np.outer(late, command[1 : n + 1])
    step = expm(system * h)
    forced = _recursion(step, forcing, (0.0, 0.0))
    none = np.zeros_like(forcing)
    free = [_recursion(step, none, start) for start in ((1.0, 0.0), (0.0, omega))]
    return tuple(_read(states, track.at, h) for states in (forced, *free))


def _hold(system: np.ndarray, omega: float, duration: float) -> np.ndarray:
    """State (2,) at rest at first, after a command of 1 held for `duration`."""
    both = np.zeros((3, 3))
    both[:2, :2], both[1, 2] = system, omega**2
    return expm(both * duration)[:2, 2]


def _recursion(step: np.ndarray, forcing: np.ndarray, start) -> np.ndarray:
    """States (2, n) of s ← step s + forcing, as a filter of second order (Cayley-Hamilton)."""
    a, b, c, d = step[0, 0], step[0, 1], step[1, 0], step[1, 1]
    poles, n = [1.0, -(a + d), a * d - b * c], forcing.shape[1]
    states = np.empty((2, n))
    for i, (cross, own) in enumerate(((b, d), (c, a))):
        into = np.zeros(n)
        into[0] = start[i]
        if n > 1:
            into[1:] = forcing[i, : n - 1]
            into[2:] += cross * forcing[1 - i, : n - 2] - own * forcing[i, : n - 2]
            into[1] += cross * start[1 - i] - own * start[i]
        states[i] = lfilter([1.0], poles, into)
    return states


def _read(states: np.ndarray, at: np.ndarray, period: float) -> np.ndarray:
    """Position at instants between those of the grid, by cubics through position and velocity."""
    below = np.minimum(at.astype(int), states.shape[1] - 1)
    above, left = np.minimum(below + 1, states.shape[1] - 1), at - below
    right = 1 - left
    (q0, v0), (q1, v1) = states[:, below], states[:, above]
    return (
        (1 + 2 * left) * right**2 * q0 + left**2 * (1 + 2 * right) * q1
        + period * (left * right**2 * v0 - left**2 * right * v1)
    )  # fmt: skip
