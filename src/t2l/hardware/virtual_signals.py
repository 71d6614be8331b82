"""What lies between a virtual robot and who commands it: set-points that come late, and noise.

Every robot has generators of its own, so that what one meets does not depend on who runs beside it.
"""

from collections.abc import Sequence

import numpy as np

_BLOCK = 256


class SetPoints:
    """Set-points (n, njoint) that come into force some ticks after they are given.

    The latency of each is drawn uniformly from its mean ± jitter. None overtakes an earlier one,
    and one that is given again is no new one.
    """

    def __init__(
        self,
        q_des: np.ndarray,
        mean: float,
        jitter: float,
        generators: Sequence[np.random.Generator],
    ):
        """Begin with q_des rad in force.

        Args:
            mean, jitter: in ticks.
            generators: one a robot.
        """
        self._mean, self._jitter, self._generators = mean, jitter, generators
        self._tick = 0
        self._given, self._in_force = q_des.copy(), q_des.copy()
        self._arrival = np.zeros(len(q_des), int)
        self._coming: list[tuple[np.ndarray, np.ndarray]] = []

    def give(self, q_des: np.ndarray) -> None:
        """Take set-points (n, njoint) rad at the present tick."""
        new = (q_des != self._given).any(axis=1)
        if not new.any():
            return
        arrival = self._arrival.copy()
        for i in np.flatnonzero(new):
            latency = self._mean + self._jitter * self._generators[i].uniform(-1, 1)
            arrival[i] = max(arrival[i], self._tick + round(latency))
        self._arrival, self._given = arrival, q_des.copy()
        self._coming.append((arrival, self._given))

    def next(self) -> np.ndarray:
        """Those in force at the present tick, (n, njoint); the next tick is then the present."""
        for arrival, q_des in self._coming:
            self._in_force = np.where((arrival <= self._tick)[:, None], q_des, self._in_force)
        self._coming = [part for part in self._coming if (part[0] > self._tick).any()]
        self._tick += 1
        return self._in_force


class Noise:
    """White, normal noise of some signals, a value a tick."""

    def __init__(self, shape: tuple[int, ...], generators: Sequence[np.random.Generator]):
        """Of signals of this shape, for as many robots as there are generators."""
        self._shape, self._generators = shape, generators
        self._at = _BLOCK

    def next(self) -> np.ndarray:
        """(n, *shape) with a standard deviation of 1."""
        if self._at == _BLOCK:
            size = (_BLOCK, *self._shape)
            self._block = np.stack([g.standard_normal(size) for g in self._generators], axis=1)
            self._at = 0
        self._at += 1
        return self._block[self._at - 1]
