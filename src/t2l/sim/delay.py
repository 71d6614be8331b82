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
        """Take the signal at the next tick, or at several (m, n, k); return it delayed."""
        if self.tick < 0:
            first = signal if signal.ndim < 3 else signal[0]
            self.past = np.repeat(np.asarray(first, float)[None], self.length, axis=0)
            self.place = np.arange(first.size).reshape(first.shape)
        if signal.ndim > 2:
            return self._several(signal) if len(signal) > 1 else self(signal[0])[None]
        self.tick += 1
        self.past[self.tick % self.length] = signal
        newer, older = self._ago(self.whole), self._ago(self.whole + 1)
        return newer + self.part * (older - newer)

    def _ago(self, ticks: np.ndarray | int) -> np.ndarray:
        at = (self.tick - ticks) % self.length
        if isinstance(at, int):
            return self.past[at]
        return self.past.ravel().take(at * self.place.size + self.place)

    def _several(self, signal: np.ndarray) -> np.ndarray:
        # the past in its order, the oldest first, then what is new
        order = np.arange(self.tick + 1, self.tick + 1 + self.length) % self.length
        known = np.concatenate([self.past[order], signal])
        tick = np.arange(self.length, len(known)).reshape(-1, 1, 1)
        flat, size = known.ravel(), self.place.size
        newer, older = (
            flat.take((tick - ago) * size + self.place) for ago in (self.whole, self.whole + 1)
        )
        self.tick += len(signal)
        last = np.arange(self.tick + 1 - self.length, self.tick + 1) % self.length
        self.past[last] = known[-self.length :]
        return newer + self.part * (older - newer)
