"""Recordings of real machines: reading, checking, splitting, importing and making them."""

from t2l.measurements.contradictions import Contradiction, contradictions
from t2l.measurements.log import read_recording, read_recordings, write_recording
from t2l.measurements.recording import Recording
from t2l.measurements.splits import hold_out, time_blocks

__all__ = [
    "Contradiction",
    "Recording",
    "contradictions",
    "hold_out",
    "read_recording",
    "read_recordings",
    "time_blocks",
    "write_recording",
]
