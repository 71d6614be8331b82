"""The samples of a comparison as `traces.parquet` holds them, and what plots make of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from t2l.artefacts import read_arrow
from t2l.diagnose.files import TRACES
from t2l.errors import ArtefactError

NAMED = ("recording", "joint")
LABEL = pa.dictionary(pa.int32(), pa.string())
COLUMNS = ("recording", "joint", "time", "q_des", "q", "q_sim", "missing_torque")


@dataclass(frozen=True)
class Traces:
    """Measured and simulated motion, one element a sample in every array.

    Attributes:
        recordings, joints: names.
        recording, joint: (nsample,) indices into them.
        columns: (nsample,) each: time, q_des, q, q_sim, missing_torque and the conditions of
            `t2l.diagnose.conditions`, in SI units.
    """

    recordings: tuple[str, ...]
    joints: tuple[str, ...]
    recording: np.ndarray
    joint: np.ndarray
    columns: dict[str, np.ndarray]

    @property
    def error(self) -> np.ndarray:
        """Measured minus simulated position (nsample,), rad."""
        return self.columns["q"] - self.columns["q_sim"]

    def at(self, recording: int, joint: int) -> np.ndarray:
        """Indices of one joint's samples in one recording, in order of time."""
        return np.flatnonzero((self.recording == recording) & (self.joint == joint))


def read_traces(folder: Path | str) -> Traces:
    """Read what `t2l.diagnose.compare.write` wrote into a folder.

    Raises:
        ArtefactError: the table is missing or unreadable, a column missing or of another type.
    """
    path = Path(folder) / TRACES
    # not read_table, which would import pandas
    table = read_arrow(path, COLUMNS, whole_table=True)
    for name, kind in zip(table.column_names, table.schema.types, strict=True):
        allowed = LABEL if name in NAMED else pa.float32()
        if kind != allowed or table[name].null_count:
            raise ArtefactError(path, f"the column {name} is {kind}", f"{allowed} without gaps")
    if not len(table):
        raise ArtefactError(path, "no rows", "some")
    recordings, recording = _labels(table["recording"])
    joints, joint = _labels(table["joint"])
    numbers = [name for name in table.column_names if name not in NAMED]
    columns = {name: _memory(_whole(table[name]), np.float32).astype(float) for name in numbers}
    return Traces(recordings, joints, recording, joint, columns)


def _whole(column: pa.ChunkedArray) -> pa.Array:
    joined = column.combine_chunks()
    return joined.chunk(0) if isinstance(joined, pa.ChunkedArray) else joined


def _memory(array: pa.Array, kind: type) -> np.ndarray:
    # the memory itself: to_numpy would import pandas, which takes a second
    size = np.dtype(kind).itemsize
    values = np.frombuffer(array.buffers()[1], kind, len(array), array.offset * size)
    return values


def _labels(column: pa.ChunkedArray) -> tuple[tuple[str, ...], np.ndarray]:
    array = _whole(column)
    return tuple(array.dictionary.to_pylist()), _memory(array.indices, np.int32)


# from memory: pa.array would import pandas, which takes a second
def column(kind: pa.DataType, values: np.ndarray) -> pa.Array:
    """A column of a table."""
    memory = np.ascontiguousarray(values, kind.to_pandas_dtype())
    return pa.Array.from_buffers(kind, len(memory), [None, pa.py_buffer(memory)])


def labels(index: np.ndarray, names: Sequence[str]) -> pa.DictionaryArray:
    """A column of names, of their indices (n,)."""
    text = [name.encode() for name in names]
    ends = np.cumsum([0, *map(len, text)], dtype=np.int32)
    buffers = [None, pa.py_buffer(ends), pa.py_buffer(b"".join(text))]
    known = pa.Array.from_buffers(pa.string(), len(text), buffers)
    return pa.DictionaryArray.from_arrays(column(pa.int32(), index), known)


# format: samples of a periodogram: half of them is more points than a figure shows
SEGMENT = 8192


# format: points of a figure
def binned(x: np.ndarray, y: np.ndarray, bins: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Mean of x and of y (n,) in bins that are spread over the range and hold enough samples.

    Edges lie halfway between equally spaced ones and quantiles, so that neither a long tail nor a
    crowded middle takes all bins.
    """
    levels = np.unique(x)
    if len(levels) <= bins:
        edges = levels
    else:
        part = np.linspace(0, 1, bins + 1)
        spread = np.quantile(x, (0.002, 0.998))  # format: what a figure shows
        edges = (spread[0] + part * (spread[1] - spread[0]) + np.quantile(x, part)) / 2
        edges = np.unique(edges)[:-1]
    bin = np.maximum(np.searchsorted(edges, x, side="right") - 1, 0)
    count = np.bincount(bin, minlength=len(edges))
    held = count >= max(3, 0.001 * len(x))  # format: of a point in a figure
    means = [np.bincount(bin, v, len(edges)) / np.maximum(count, 1) for v in (x, y)]
    return means[0][held], means[1][held]


def spectrum(traces: Traces, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude density of a joint's position error over frequency, Hz and rad/√Hz.

    Periodograms of equal length with a Hann window, half overlapping, averaged over the
    recordings in power (Welch, 1967). They are as long as the shortest recording, or have `SEGMENT`
    samples.
    """
    # not scipy.signal.welch: it averages over one recording, and takes seconds to import
    series = []
    for recording in range(len(traces.recordings)):
        at = traces.at(recording, joint)
        if len(at) > 8:  # numerics: fewer have no spectrum
            series.append((traces.columns["time"][at], traces.error[at]))
    if not series:
        return np.zeros(0), np.zeros(0)
    rates = [1.0 / np.median(np.diff(time)) for time, _ in series]
    length = min(min(time[-1] - time[0] for time, _ in series), SEGMENT / max(rates))
    power, count = np.zeros((2, SEGMENT))
    for (time, error), rate in zip(series, rates, strict=True):
        even = np.arange(time[0], time[-1] + 0.5 / rate, 1.0 / rate)
        values = np.interp(even, time, error)
        size = round(length * rate)
        window = np.hanning(size)
        for start in range(0, len(values) - size + 1, max(1, size // 2)):
            part = values[start : start + size]
            density = 2 * np.abs(np.fft.rfft((part - part.mean()) * window)[1:]) ** 2
            power[: len(density)] += density / (rate * np.sum(window**2))
            count[: len(density)] += 1
    numbers = np.flatnonzero(count)
    return (numbers + 1) / length, np.sqrt(power[numbers] / count[numbers])
