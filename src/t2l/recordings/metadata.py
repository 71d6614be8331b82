"""The YAML of a recording: which robot and joints, under which controller."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, ValidationInfo

from t2l.documents import check_regular
from t2l.errors import RecordingError
from t2l.recordings.control import CONTROLS, DUTY, POSITION, TORQUE, VELOCITY
from t2l.recordings.keys import checked
from t2l.recordings.motor import Motor, of_table
from t2l.recordings.per_joint import per_joint
from t2l.recordings.recording import CONTINUOUS, Recording
from t2l.robots import ROBOTS
from t2l.typed import Number, Typed, describe, is_number, refuse, suggestion, switch

JOINTS_ALLOWED = "a list of different joint names in printable characters, in the columns' order"
COMPENSATION_ALLOWED = f"true or false, or {CONTINUOUS}"
# bound: more is another motion's sample
MOST_SKEW_S = 1.0
SKEW_ALLOWED = f"seconds by joint, or one number for each joint, up to {MOST_SKEW_S:g} s"
SUPPLY_COLUMN = "supply_voltage"  # format: the column that a motor's supply may be

# bound: the slowest loop that holds a joint, and faster than any that a computer runs
LEAST_CONTROL_RATE_HZ, LARGEST_RATE_HZ = 1, 100_000

# format: of the YAML, and of that of a motor under a voltage
UNITS_OF_GAINS = {"kp": ("N·m/rad", "duty/rad"), "kd": ("N·m·s/rad", "duty·s/rad")}


def _joint_names(value: Any) -> tuple[str, ...]:
    fine = isinstance(value, list) and value
    # they appear in messages, on terminals and in files of every format
    fine = fine and all(isinstance(n, str) and n and n.isprintable() for n in value)
    if not fine or len(set(value)) < len(value):
        raise refuse(JOINTS_ALLOWED)
    return tuple(value)


def _compensation(value: Any) -> bool | str:
    value = switch(value)
    if not isinstance(value, bool) and value != CONTINUOUS:
        raise refuse(COMPENSATION_ALLOWED)
    return value


def _supply(value: Any, info: ValidationInfo) -> np.ndarray | str:
    if value == SUPPLY_COLUMN:
        return value
    numbers = value if isinstance(value, list) else [value] * info.context
    if len(numbers) != info.context or not all(is_number(n) and n > 0 for n in numbers):
        raise refuse(
            f"one number above 0, or {info.context}, one for each joint, in V; or {SUPPLY_COLUMN}, "
            "the column"
        )
    return np.array(numbers, float)


def _skew(value: Any, info: ValidationInfo) -> np.ndarray | None:
    joints = info.data.get("joints")
    if joints is None:  # what is wrong with them is told instead
        return None
    if isinstance(value, Mapping):
        for name in value:
            if name not in joints:
                shown = f"{describe(name)}{suggestion(name, joints)}"
                raise refuse(f"joints of this recording: {', '.join(joints)}", shown)
        value = [value.get(name, 0.0) for name in joints]
    fine = isinstance(value, list) and len(value) == len(joints) and all(map(is_number, value))
    if not fine or any(abs(s) > MOST_SKEW_S for s in value):
        raise refuse(SKEW_ALLOWED)
    return np.array(value, float) if any(value) else None


def _point(value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != 3 or not all(map(is_number, value)):
        raise refuse("three numbers, in m")
    return tuple(map(float, value))


Rate = Annotated[Number, Field(gt=0, le=LARGEST_RATE_HZ, description="a number above 0, in Hz")]


class MotorFile(Typed):
    """The section `motor` of a recording's YAML: a drive under a voltage."""

    kt: Annotated[per_joint(above=0, unit="N·m/A"), Field(description="numbers, in N·m/A")]
    resistance: Annotated[per_joint(above=0, unit="Ω"), Field(description="numbers, in Ω")]
    supply: Annotated[
        Any,
        PlainValidator(_supply, json_schema_input_type=float | list[float] | str),
        Field(description=f"numbers, in V, or {SUPPLY_COLUMN}"),
    ]
    gear: per_joint(above=0) = None


class Metadata(Typed):
    """What a recording's YAML holds."""

    robot: Annotated[
        str, Field(min_length=1, description="a name, or the path of an MJCF or URDF file")
    ]
    joints: Annotated[
        tuple[Annotated[str, Field(min_length=1)], ...],
        BeforeValidator(_joint_names),
        Field(description=JOINTS_ALLOWED),
    ]
    control: Literal["position", "velocity", "torque", "duty"] = POSITION
    motor: dict[str, Any] | None = None
    kp: per_joint(at_least=0, unit="N·m/rad") = None
    kd: per_joint(at_least=0, unit="N·m·s/rad") = None
    command_rate_hz: Rate
    control_rate_hz: Annotated[Rate, Field(ge=LEAST_CONTROL_RATE_HZ)]
    gravity_compensation: Annotated[
        bool | Literal["continuous"],
        BeforeValidator(_compensation),
        Field(description=COMPENSATION_ALLOWED),
    ]
    skew_s: Annotated[
        Any,
        PlainValidator(_skew, json_schema_input_type=dict[str, float] | list[float]),
        Field(description=SKEW_ALLOWED),
    ] = None
    base_position: Annotated[tuple[Number, ...] | None, BeforeValidator(_point)] = None
    notes: str = ""

    def arguments(self, path: Path) -> dict[str, Any]:
        """As keyword arguments of `Recording`.

        Args:
            path: of the YAML, which the path of a robot's MJCF is relative to.

        Raises:
            RecordingError: the robot is neither a known name nor a file.
        """
        values = {name: getattr(self, name) for name in Metadata.model_fields}
        return (
            values
            | self._gains(path)
            | {
                "motor": self._motor(path),
                "robot": _robot(self.robot, path),
                "command_rate_hz": float(self.command_rate_hz),
                "control_rate_hz": float(self.control_rate_hz),
            }
        )

    def _motor(self, path: Path) -> Motor | None:
        if self.motor is None:
            if self.control == DUTY:
                allowed = f"the keys {', '.join(MotorFile.model_fields)}, as control is {DUTY}"
                raise RecordingError(path, "key motor", "nothing", allowed)
            return None
        if self.control == TORQUE:
            raise RecordingError(
                path, "key motor", "it, where control is torque", f"control: {DUTY}, or no motor: "
                "a drive that follows torque sees to the voltage itself",
            )  # fmt: skip
        count = len(self.joints)
        found = checked(MotorFile, self.motor, path, "motor.", context=count)
        gear = np.ones(count) if found.gear is None else found.gear
        logged = isinstance(found.supply, str)
        supply = np.full(count, np.nan) if logged else found.supply
        return Motor(found.kt * gear, found.resistance, supply, logged)

    def _gains(self, path: Path) -> dict[str, np.ndarray]:
        """Those that the control has; zero for others."""
        taken, found = CONTROLS[self.control].gains, {}
        for key, units in UNITS_OF_GAINS.items():
            given, unit = getattr(self, key), units[self.motor is not None]
            if given is None and key in taken:
                raise RecordingError(path, f"key {key}", "nothing", f"numbers, in {unit}")
            if given is not None and key not in taken and given.any():
                raise RecordingError(
                    path, f"key {key}", f"{describe(_one_or_each(given))}, where control is "
                    f"{self.control}", f"no such key, or 0; a control that has it: "
                    f"{', '.join(n for n, c in CONTROLS.items() if key in c.gains)}",
                )  # fmt: skip
            found[key] = np.zeros(len(self.joints)) if given is None else given
        if self.control == VELOCITY and not (found["kd"] > 0).any():
            raise RecordingError(path, "key kd", "0", "above 0 for some joint: control is velocity")
        return found


def check_metadata(values: Any, path: Path) -> dict[str, Any]:
    """The content of a recording's YAML as keyword arguments of `Recording`.

    Args:
        values: what the YAML holds.
        path: the YAML, for messages and for a robot's path relative to it.

    Raises:
        RecordingError: a key is missing, unknown, or of a wrong type, count or sign.
    """
    return checked(Metadata, values, path).arguments(path)


def as_written(recording: Recording, path: Path) -> dict[str, Any]:
    """What the YAML at `path` has to hold."""
    recording, robot = of_table(recording), recording.robot
    if robot not in ROBOTS.names():
        robot = os.path.relpath(robot, path.parent.resolve())
    metadata = {
        "robot": robot,
        "joints": list(recording.joints),
        **({"control": recording.control} if recording.drifts else {}),
        **{key: _one_or_each(getattr(recording, key)) for key in recording.by.gains},
        "command_rate_hz": _plain(recording.command_rate_hz),
        "control_rate_hz": _plain(recording.control_rate_hz),
        "gravity_compensation": _switch(recording.gravity_compensation),
    }
    if recording.motor is not None:
        motor = recording.motor
        metadata["motor"] = {
            "kt": _one_or_each(motor.kt),
            "resistance": _one_or_each(motor.resistance),
            "supply": SUPPLY_COLUMN if motor.logged else _one_or_each(motor.supply),
        }
    if recording.skew_s is not None:
        metadata["skew_s"] = dict(zip(recording.joints, map(_plain, recording.skew_s), strict=True))
    if recording.base_position is not None:
        metadata["base_position"] = [float(x) for x in recording.base_position]
    if recording.notes:
        metadata["notes"] = recording.notes
    return metadata


def _switch(value: Any) -> bool | str:
    # a NumPy bool is none that YAML knows
    return value if value == CONTINUOUS else bool(value)


def _one_or_each(gains: np.ndarray) -> float | list[float]:
    each = [_plain(gain) for gain in gains]
    return each[0] if (gains == gains[0]).all() else each


def _plain(number: float) -> float:
    # 64 reads better than 64.0
    return int(number) if float(number).is_integer() else float(number)


def _robot(value: str, path: Path) -> str:
    names = ROBOTS.names()
    if value in names:
        return value
    model = (path.parent / value).resolve()
    # os.path: of a name that is too long for a file, pathlib makes an error
    if os.path.exists(model):
        check_regular(model, RecordingError)
        return str(model)
    found = f"{describe(value)}{suggestion(value, names)}"
    if value.endswith((".xml", ".mjcf", ".urdf")):
        found = f"{describe(value)}, but there is no file {model}"
    allowed = f"{', '.join(names)}, or the path of an MJCF or URDF file, relative to this YAML"
    raise RecordingError(path, "key robot", found, allowed)
