"""Recordings that no machine made."""

import dataclasses

import numpy as np
import yaml

from t2l.recordings import Recording, write_recording

JOINTS = ("a", "b")


def recording(name="swing", kp=64.0, kd=4.0, duration_s=1.0, lag_s=0.05, **changes):
    """Two joints that follow sines, commanded at 50 Hz and sampled at 25 Hz."""
    time = np.arange(round(duration_s * 50)) / 50

    def sine(t):
        return np.stack([0.1 * np.sin(2 * t), 0.2 * np.cos(2 * t) - 1.5], axis=1)

    q = sine(np.maximum(time - lag_s, 0))
    q[1::2] = np.nan
    made = Recording(
        name=name,
        path=None,
        robot="fr3",
        joints=JOINTS,
        kp=np.full(2, kp),
        kd=np.full(2, kd),
        command_rate_hz=50.0,
        control_rate_hz=1000.0,
        gravity_compensation=True,
        time=time,
        q_des=sine(time),
        q=q,
    )
    return dataclasses.replace(made, **changes)


def written(folder, **changes):
    """Such a recording in a folder: its table as lines of cells, its YAML, and a way back."""
    made = recording(**changes)
    return Files(write_recording(made, folder / made.name))


class Files:
    """A recording's CSV and YAML, to be spoilt."""

    def __init__(self, table):
        self.table = table
        self.yaml = table.with_suffix(".yaml")
        self.rows = [line.split(",") for line in table.read_text().splitlines()]
        self.keys = yaml.safe_load(self.yaml.read_text())

    def spoil_row(self, row, column, cell):
        """Put `cell` into a data row, counted from 1."""
        self.rows[row][self.rows[0].index(column)] = cell
        self.save()

    def spoil_key(self, key, value):
        self.keys[key] = value
        self.save()

    def save(self):
        self.table.write_text("\n".join(map(",".join, self.rows)) + "\n")
        self.yaml.write_text(yaml.safe_dump(self.keys))
