"""A signal as it was some ticks ago."""

import numpy as np


class DelayLine:
    """Keeps as much of a signal (n, k) as its delays need.

    Before its first value a signal was what that is.
    """

    def __init__(self, ticks: np.ndarray):
        """Delay by `ticks`, broadcasting to (n, k); between two ticks the signal is linear."""
        whole = np.floor(ticks + 1e-9).astype(int)
        self.part = ticks - whole
        self.length = int(whole.max()) + 2
        # one number for all is looked up much faster
        self.whole = whole if np.ptp(whole) else int(whole.max())
        self.tick = -1

    def __call__(self, signal: np.ndarray) -> np.ndarray:
        """Take the signal at the next tick; return it delayed."""
        self.tick += 1
        if self.tick == 0:
            self.past = np.repeat(np.asarray(signal, float)[None], self.length, axis=0)
            self.place = np.arange(signal.size).reshape(signal.shape)
        self.past[self.tick % self.length] = signal
        newer, older = self._ago(self.whole), self._ago(self.whole + 1)
        return newer + self.part * (older - newer)

    def _ago(self, ticks: np.ndarray | int) -> np.ndarray:
        at = (self.tick - ticks) % self.length
        if isinstance(at, int):
            return self.past[at]
        return self.past.ravel().take(at * self.place.size + self.place)
