"""What `t2l record` is to do: a YAML, checked as a whole, with every command computed."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import create_model

from t2l.documents import read_yaml
from t2l.errors import ConfigurationError, InputError, RecordingError
from t2l.gains import Cell
from t2l.hardware import excitation_kinds
from t2l.hardware.backend import Backend
from t2l.hardware.features import Features
from t2l.hardware.limits import check_loop, check_motion, check_responses, motion_torque
from t2l.hardware.motion import Motion
from t2l.hardware.nominal import SampledLoop, respond
from t2l.hardware.plan_file import MOST_GAINS, Driven, Gains, Limits, NamedMotion, PlanFile
from t2l.hardware.registry import BACKENDS
from t2l.recordings.keys import checked
from t2l.registry import Registry
from t2l.robots import ROBOTS, Robot, make_robot, plant
from t2l.robots.from_file import RobotFromFile
from t2l.typed import Typed

# numerics: commands of joints that are simulated side by side: 8 bytes each, and a few copies
_AT_ONCE = 20_000_000


@dataclass(frozen=True, eq=False)
class Setup:
    """All of a configuration but its motions.

    Attributes:
        path: the configuration.
        robot: that moves.
        backend: through which it does, with its `settings`.
        features: of the two.
        start: (njoint,) rad, where motions begin and end unless they say otherwise.
        found: what is written, by type; `written` as it stands in the file.
    """

    path: Path
    robot: Robot
    backend: type[Backend]
    settings: Typed
    features: Features
    start: np.ndarray
    found: PlanFile
    written: Mapping[str, Any]

    @property
    def command_rate_hz(self) -> float:
        """How often commands change."""
        return float(self.found.command_rate_hz)

    def gains(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """kp N·m/rad and kd N·m·s/rad, (njoint,), by the name of a recording.

        Raises:
            RecordingError: they are missing or wrong.
        """
        return _gains(self.found, self.path, len(self.robot.joints))


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked configuration of recordings.

    Attributes:
        path: the configuration.
        robot: that moves.
        backend: through which it does, with its `settings`.
        motions: one for each recording.
    """

    path: Path
    robot: Robot
    backend: type[Backend]
    settings: Typed
    motions: tuple[Motion, ...]


def read_plan(path: Path | str) -> Plan:
    """Read a configuration and check all that it asks of the robot.

    Every motion is simulated under its gains, by the nominal model.

    Raises:
        RecordingError: a key is missing, unknown or wrong, a motion is beyond a limit, its
            simulation is, or its gains make a joint ring.
        ConfigurationError: the back end does not drive the robot.
    """
    setup = read_setup(path)
    path, found, robot = setup.path, setup.found, setup.robot
    motions = _alike(setup) if found.motions is None else _named(setup)
    for q_des, group in motions:
        torque = motion_torque(robot, q_des, setup.command_rate_hz)
        for motion in group:
            check_motion(robot, motion, torque, path)
    flat = tuple(motion for _, group in motions for motion in group)
    check_simulated(setup, flat)
    return Plan(path, robot, setup.backend, setup.settings, flat)


def check_simulated(setup: Setup, motions: Sequence[Motion]) -> None:
    """Whether the nominal model makes motions within all limits, under gains that damp it.

    Raises:
        RecordingError: a joint rings, or a position, velocity or torque is beyond its limit.
    """
    robot, features, path = setup.robot, setup.features, setup.path
    loops: dict[bytes, SampledLoop] = {}
    for motion in motions:
        start = motion.q_des[0]
        key = start.tobytes()
        loops[key] = loops.get(key) or SampledLoop(robot, features, start)
        check_loop(robot, loops[key], motion, path)
    ticks = features.control_rate_hz / setup.command_rate_hz
    for length in sorted({len(motion.q_des) for motion in motions}):
        alike = [motion for motion in motions if len(motion.q_des) == length]
        size = max(1, int(_AT_ONCE / (length * ticks * len(robot.joints))))
        for first in range(0, len(alike), size):
            some = alike[first : first + size]
            q_des, kp, kd = (
                np.stack([getattr(motion, name) for motion in some])
                for name in ("q_des", "kp", "kd")
            )
            response = respond(robot, features, q_des, setup.command_rate_hz, kp, kd)
            check_responses(robot, some, response, path)


def read_setup(path: Path | str) -> Setup:
    """Read all of a configuration but its gains and motions.

    Raises:
        RecordingError: a key is unknown or wrong.
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
        features = backend.features(robot, settings)
    # also of a file that the configuration names
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from None
    _check_rates(found, features, path)
    start = robot.home if found.start_rad is None else found.start_rad
    return Setup(path, robot, backend, settings, features, start, found, content)


def _alike(setup: Setup) -> list[tuple[np.ndarray, list[Motion]]]:
    """The one excitation under each pair of gains."""
    path, found = setup.path, setup.found
    if found.excitation is None:
        raise RecordingError(path, "key excitation", "nothing", "the keys of an excitation")
    q_des, notes = _commands(setup, found.excitation, None, "excitation.")
    motions = [
        Motion(name, q_des, setup.command_rate_hz, kp, kd, notes)
        for name, (kp, kd) in setup.gains().items()
    ]
    return [(q_des, motions)]


def _named(setup: Setup) -> list[tuple[np.ndarray, list[Motion]]]:
    """Each of `motions` with its own gains."""
    path, found = setup.path, setup.found
    for key in ("excitation", "gains"):
        if getattr(found, key) is not None:
            raise RecordingError(path, f"key {key}", "it beside motions", "one of the two")
    motions: dict[str, tuple[np.ndarray, list[Motion]]] = {}
    for number, written in enumerate(found.motions):
        where = f"motions[{number}]."
        one = checked(NamedMotion, written, path, where, context=len(setup.robot.joints))
        pair = checked(Gains, one.gains, path, f"{where}gains.", context=len(setup.robot.joints))
        if one.name in motions:
            raise RecordingError(path, f"key {where}name", f"{one.name} twice", "different names")
        q_des, notes = _commands(setup, one.excitation, one.start_rad, f"{where}excitation.")
        name = f"{found.name}_{one.name}" if found.name else one.name
        motion = Motion(name, q_des, setup.command_rate_hz, pair.kp, pair.kd, notes)
        motions[one.name] = q_des, [motion]
    return list(motions.values())


def _commands(
    setup: Setup, section: Mapping[str, Any], start: np.ndarray | None, prefix: str
) -> tuple[np.ndarray, str]:
    offsets, described = excitation_kinds.offsets(
        section, setup.path, len(setup.robot.joints), setup.command_rate_hz, prefix
    )
    begun = setup.start if start is None else start
    return begun + offsets, "; ".join(filter(None, (setup.found.notes, described)))


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
    if robot not in ROBOTS.names() and os.path.isfile(file := path.parent / robot):
        return _from_file(file, written.get("limits"), path), backend
    _find(ROBOTS, robot, path)
    if written.get("limits") is not None:
        raise RecordingError(path, "key limits", f"it for {robot}", "the limits that it has")
    return make_robot(robot), backend


def _from_file(file: Path, limits: Any, path: Path) -> Robot:
    try:
        njoint = len(plant.scalar_joints(str(file)))
        stated = checked(Limits, {} if limits is None else limits, path, "limits.", context=njoint)
        return RobotFromFile(file, stated.velocity_rad_s, stated.torque_nm)
    except InputError:
        raise
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from None


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
    if value is None:
        raise RecordingError(path, "key gains", "nothing", "kp and kd, or a list of such pairs")
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
