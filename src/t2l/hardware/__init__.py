"""Robots at the other end: back ends by name, what is recorded from them, and what guards them."""

from t2l.hardware.backend import Backend, BackendError, PositionControlled
from t2l.hardware.features import Features, State
from t2l.hardware.registry import BACKENDS, find_backend, open_backend, recorded_files, truth_of

__all__ = [
    "BACKENDS",
    "Backend",
    "BackendError",
    "Features",
    "PositionControlled",
    "State",
    "find_backend",
    "open_backend",
    "recorded_files",
    "truth_of",
]
