"""Recordings out of what other recorders write."""

from t2l.recordings.importers.csv_mapping import Mapping, read_mapped, read_mapping
from t2l.recordings.importers.lerobot import read_lerobot, read_lerobot_positions
from t2l.recordings.importers.rosbag import read_bag, read_bag_mapping

__all__ = [
    "Mapping",
    "read_bag",
    "read_bag_mapping",
    "read_lerobot",
    "read_lerobot_positions",
    "read_mapped",
    "read_mapping",
]
