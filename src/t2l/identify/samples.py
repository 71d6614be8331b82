"""Where recordings were measured, all of them in one flat row of samples."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from t2l.recordings.recording import Recording


@dataclass(frozen=True)
class Samples:
    """Every measured position of some recordings, (nsample,) each.

    Attributes:
        recording, joint, row: indices.
        time: s since the recording's start, when it was taken; see `Recording.skew_s`.
        q: rad, measured.
        shapes: (n, njoint) of each recording's signals.
    """

    recording: np.ndarray
    joint: np.ndarray
    row: np.ndarray
    time: np.ndarray
    q: np.ndarray
    shapes: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return len(self.q)

    @classmethod
    def measured(cls, recordings: Sequence[Recording]) -> "Samples":
        """Those of `recordings`, in their order and by row and joint within each."""
        parts = []
        for index, recording in enumerate(recordings):
            # what was taken before the first command is not simulated
            row, joint = np.nonzero(~np.isnan(recording.q) & (recording.taken_s >= 0))
            time = recording.taken_s[row, joint]
            parts.append((np.full(len(row), index), joint, row, time, recording.q[row, joint]))
        columns = (np.concatenate(column) for column in zip(*parts, strict=True))
        return cls(*columns, tuple(recording.q.shape for recording in recordings))

    def of(self, signals: Sequence[np.ndarray]) -> np.ndarray:
        """(nsample,) values of signals (n, njoint), one a recording."""
        first = np.cumsum([0, *(len(signal) for signal in signals)])[self.recording]
        return np.concatenate(signals)[first + self.row, self.joint]

    def by_row(self, values: np.ndarray) -> list[np.ndarray]:
        """Values (nsample,) as one array (n, njoint) a recording, NaN where not measured."""
        signals = [np.full(shape, np.nan) for shape in self.shapes]
        for i, signal in enumerate(signals):
            at = self.recording == i
            signal[self.row[at], self.joint[at]] = values[at]
        return signals
