"""The physics of the virtual FR3, read from the one file that holds it."""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import yaml

PATH = Path(__file__).with_name("virtual_fr3.yaml")
_PER_JOINT = (
    "gear_stiffness", "gear_damping_ratio", "bristle_stiffness", "bristle_damping_ratio", "coulomb",
    "breakaway_ratio", "stribeck_velocity", "viscous", "torque_offset", "torque_limit",
    "torque_rate_limit",
)  # fmt: skip


@dataclass(frozen=True)
class VirtualPhysics:
    """What ``virtual_fr3.yaml`` says, each with its unit and source there; arrays are (7,)."""

    physics_rate_hz: float
    control_rate_hz: float
    gear_stiffness: np.ndarray
    gear_damping_ratio: np.ndarray
    bristle_stiffness: np.ndarray
    bristle_damping_ratio: np.ndarray
    coulomb: np.ndarray
    breakaway_ratio: np.ndarray
    stribeck_velocity: np.ndarray
    viscous: np.ndarray
    torque_offset: np.ndarray
    torque_limit: np.ndarray
    torque_rate_limit: np.ndarray
    command_latency_s: float
    encoder_resolution_rad: float
    velocity_cutoff_hz: float


def read() -> VirtualPhysics:
    """The file's values."""
    entries = yaml.safe_load(PATH.read_text())
    values = {field.name: entries[field.name]["value"] for field in fields(VirtualPhysics)}
    for name in _PER_JOINT:
        values[name] = np.broadcast_to(np.asarray(values[name], float), 7)
    return VirtualPhysics(**values)
