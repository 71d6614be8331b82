"""A signal as it was some ticks ago."""

import numpy as np


class DelayLine:
    """Keeps as much of a signal (n, k) as its delays need.

    Before its first value a signal was what that is.
    """

    def __init__(self, ticks: np.ndarray):
        """Delay by `ticks`, broadcasting to (n, k); between two ticks the signal is linear."""
        self.whole = np.floor(ticks + 1e-9).astype(int)
        self.part = ticks - self.whole
        self.length = int(self.whole.max()) + 2
        self.tick = -1

    def __call__(self, signal: np.ndarray) -> np.ndarray:
        """Take the signal at the next tick; return it delayed."""
        self.tick += 1
        if self.tick == 0:
            self.past = np.empty((self.length, *signal.shape))
            self.place = np.ogrid[tuple(slice(n) for n in signal.shape)]
        self.past[self.tick % self.length] = signal
        newer, older = self._ago(self.whole), self._ago(self.whole + 1)
        return newer + self.part * (older - newer)

    def _ago(self, ticks: np.ndarray) -> np.ndarray:
        return self.past[(np.maximum(self.tick - ticks, 0) % self.length, *self.place)]
