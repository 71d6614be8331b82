"""Success as a state that lasts."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from t2l.tasks.task import Monitor


class HeldMonitor(Monitor):
    """A simulation is a success once what is to be reached has held for `HOLD_S` unbroken."""

    HOLD_S: ClassVar[float] = 0.0

    def __init__(self, nsim: int):
        self.success_time_s = np.full(nsim, np.nan)
        self._since_s = np.full(nsim, np.nan)

    def held(self, reached: np.ndarray, time_s: float) -> None:
        """Take in what has been reached at a time, (nsim,) bool."""
        self._since_s[~reached] = np.nan
        self._since_s[reached & np.isnan(self._since_s)] = time_s
        # a time is a sum of ticks, exact to rounding
        done = reached & (time_s - self._since_s >= self.HOLD_S - 1e-9)
        self.success_time_s[done & np.isnan(self.success_time_s)] = time_s

    def named(
        self, running: np.ndarray, kinds: Sequence[tuple[str, np.ndarray]], otherwise: str
    ) -> list[str]:
        """As `Monitor.failures`: of neither success nor divergence the first kind that holds.

        Args:
            kinds: names, and where they hold, (nsim,) bool.
        """
        kinds = [("", ~np.isnan(self.success_time_s)), ("diverged", ~running), *kinds]
        names, holds = zip(*kinds, strict=True)
        return np.select(holds, names, otherwise).tolist()
