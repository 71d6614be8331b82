"""Logs of every cycle of a controller, and the rows of them that a recording keeps."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True, eq=False)
class Cycles:
    """What a robot was told and measured at some instants.

    Attributes:
        time: (n,) s, from the first of them.
        q_des: (n, njoint) rad, in force from each instant on.
        measured: (n, njoint) of each signal, by its name.
    """

    time: np.ndarray
    q_des: np.ndarray
    measured: Mapping[str, np.ndarray]

    def at(self, rows: np.ndarray) -> "Cycles":
        """Some of them; time is from the first of these."""
        measured = {name: values[rows] for name, values in self.measured.items()}
        # control loops count cycles in whole µs; more digits are rounding
        time = np.round(self.time[rows] - self.time[rows[0]], 6)
        return Cycles(time, self.q_des[rows], measured)


def rows_of_commands(q_des: np.ndarray, period: int) -> np.ndarray:
    """Cycles that first used a command, (m,), and others between where one held for long.

    Args:
        q_des: rad, (n, njoint), that each cycle used.
        period: cycles that a command is to hold.
    """
    changes = np.flatnonzero((np.diff(q_des, axis=0) != 0).any(axis=1)) + 1
    edges = [0, *changes.tolist(), len(q_des)]
    rows: list[int] = []
    for begin, end in pairwise(edges):
        # a row too close to the next change would say nothing new
        rows += range(begin, max(begin + 1, end - period // 2), period)
    return np.array(rows)
