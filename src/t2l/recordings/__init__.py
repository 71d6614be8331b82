"""Recordings of real machines: reading, checking, splitting, importing and making them."""

from t2l.recordings.contradictions import Contradiction, contradictions
from t2l.recordings.log import read_recording, read_recordings, write_recording
from t2l.recordings.recording import Recording
from t2l.recordings.splits import hold_out, time_blocks

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
