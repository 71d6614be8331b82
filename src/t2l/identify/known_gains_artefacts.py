"""Actuators that all cells share, on disk: a file that a person can read."""

from pathlib import Path

import numpy as np

from t2l.artefacts import read_yaml, reading, write_text
from t2l.effects.actuator import Actuator
from t2l.identify.known_gains import NAMES, Actuators
from t2l.sim.training_simulator import Parameters

WHAT = "actuators that were identified from all cells"


def write_actuators(found: Actuators, joints: tuple[str, ...], path: Path | str) -> None:
    """Write YAML: by joint, with units and intervals, and what ended on a bound."""
    lines = [
        "# identified from the recordings of all cells under the gains that they were given",
        f"joints: [{', '.join(joints)}]",
        "actuators:",
    ]
    for p in Actuator.parameters:
        lines.append(f"  {p.name}: {_row(found.values[p.name])}  # {p.unit}, {p.meaning}")
    lines.append("interval_95:  # of every joint, by blocks of time")
    for p in Actuator.parameters:
        pairs = ", ".join(_row(pair) for pair in found.intervals[p.name])
        lines.append(f"  {p.name}: [{pairs}]")
    on_bound = ", ".join(f"{name} of {joints[joint]}" for name, joint in found.bounds)
    lines.append(f"on_bound: [{on_bound}]")
    write_text("\n".join(lines) + "\n", path)


def read_actuators(path: Path | str) -> tuple[Parameters, list[tuple[str, int]]]:
    """The values (njoint,) of a file that `write_actuators` made, and what ended on a bound.

    Raises:
        ArtefactError: it is not one.
    """
    content = read_yaml(path, WHAT, ("joints", "actuators", "on_bound"))
    with reading(path, WHAT):
        joints = content["joints"]
        values = {name: np.array(content["actuators"][name], float) for name in NAMES}
        for name, numbers in values.items():
            if numbers.shape != (len(joints),) or not np.isfinite(numbers).all():
                raise ValueError(f"{name} is not one finite number a joint")
        pairs = [text.split(" of ", 1) for text in content["on_bound"]]
        bounds = [(name, joints.index(joint)) for name, joint in pairs]
    return values, bounds


def _row(numbers: np.ndarray) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in numbers) + "]"
