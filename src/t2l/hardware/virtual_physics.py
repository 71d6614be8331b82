"""The physics of the virtual robots, each read from the one file that holds it.

`EFFECTS` names what can be left out, to see what follows from it: `without(physics, name)`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import inf
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, create_model

from t2l.documents import read_yaml
from t2l.errors import ConfigurationError
from t2l.robots import Robot
from t2l.typed import Invalid, Typed, check

_FOLDER = Path(__file__).parent
_PREFIX = "virtual_"


@dataclass(frozen=True)
class VirtualPhysics:
    """What a file says, each with its unit and source there; arrays are (njoint,).

    Attributes:
        wrist: (njoint,) bool, the joints that are not proximal; of the robot, not of the file.
    """

    wrist: np.ndarray

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
    torque_bandwidth_hz: float
    policy_latency_s: float
    policy_latency_jitter_s: float
    command_latency_s: float
    encoder_resolution_rad: float
    position_noise_rad: float
    velocity_noise_rad_s: float
    velocity_cutoff_hz: float


# the keys of each effect, and their values where it is absent
EFFECTS: Mapping[str, Mapping[str, float]] = {
    "policy_latency": {"policy_latency_s": 0.0, "policy_latency_jitter_s": 0.0},
    "velocity_noise": {"velocity_noise_rad_s": 0.0},
    "position_noise": {"position_noise_rad": 0.0},
    "torque_bandwidth": {"torque_bandwidth_hz": inf},
    "wrist_friction": {"coulomb": 0.0},
    # critically damped: the gear gives way, and does not swing
    "gear_resonance": {"gear_damping_ratio": 1.0},
    "friction": {"coulomb": 0.0},
    "breakaway": {"breakaway_ratio": 1.0},
    "viscous_friction": {"viscous": 0.0},
    "torque_offset": {"torque_offset": 0.0},
    "torque_rate_limit": {"torque_rate_limit": inf},
    "command_latency": {"command_latency_s": 0.0},
    "encoder_resolution": {"encoder_resolution_rad": 0.0},
    "velocity_filter": {"velocity_cutoff_hz": inf},
}
OF_THE_WRIST = ("wrist_friction",)


def without(physics: VirtualPhysics, name: str) -> VirtualPhysics:
    """The physics with one of `EFFECTS` absent.

    Raises:
        KeyError: there is no such effect.
    """
    changed = {}
    for key, absent in EFFECTS[name].items():
        value = getattr(physics, key)
        where = physics.wrist if name in OF_THE_WRIST else np.ones(np.shape(value), bool)
        changed[key] = np.where(where, absent, value) if np.ndim(value) else absent
    return replace(physics, **changed)


class Entry(Typed):
    """A key of a file."""

    value: float | list[float] = Field(description="a number, or a list of one a joint")
    source: Annotated[str, Field(min_length=1)] = Field(description="where the value is from")


_KEYS = [field for field in fields(VirtualPhysics) if field.name != "wrist"]

PhysicsFile = create_model(
    "PhysicsFile",
    __base__=Typed,
    __doc__="A file as it is written.",
    **{field.name: (Entry, Field(description="`value` and `source`")) for field in _KEYS},
)


def known() -> dict[str, Path]:
    """The files of the robots that the library has, by the robots' names."""
    return {
        path.stem.removeprefix(_PREFIX): path for path in sorted(_FOLDER.glob(f"{_PREFIX}*.yaml"))
    }


def read(robot: Robot, path: Path | str | None = None) -> VirtualPhysics:
    """The physics of a robot.

    Args:
        path: of a file of the user's; by default the library's for this robot.

    Raises:
        ConfigurationError: there is none, it lacks a key, or a list has not one number a joint.
    """
    if path is None:
        files = known()
        if robot.name not in files:
            raise ConfigurationError(
                f"robot {robot.name}: has no physics for the virtual robot; allowed: "
                f"{', '.join(files)}, or a file of your own under the key `physics`"
            )
        path = files[robot.name]
    try:
        entries = check(PhysicsFile, read_yaml(path, "a file of a virtual robot's physics"))
    except Invalid as error:
        raise ConfigurationError(f"{path}: {error}") from None
    njoint = len(robot.joints)
    values = {}
    for field in _KEYS:
        value = np.asarray(getattr(entries, field.name).value, float)
        per_joint = field.type is np.ndarray
        if value.shape not in ((), (njoint,) if per_joint else ()):
            allowed = f"one number, or a list of {njoint}" if per_joint else "one number"
            raise ConfigurationError(
                f"{path}: {field.name}: found a list of {value.size}; allowed: {allowed}"
            )
        values[field.name] = np.broadcast_to(value, njoint) if per_joint else float(value)
    return VirtualPhysics(wrist=~robot.proximal, **values)
