"""Configurations: what their keys may hold, and the study that a checked one describes."""

from t2l.config.study import SIMULATION_RATE_HZ, Study, effective, read_study

__all__ = ["SIMULATION_RATE_HZ", "Study", "effective", "read_study"]
