"""What `t2l record` is to do: a YAML, checked as a whole, with every command computed."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from t2l.documents import read_yaml
from t2l.errors import RecordingError
from t2l.gains import Cell
from t2l.hardware import excitation
from t2l.hardware.franka_arm import CONTROL_RATE_HZ, SIMULATION
from t2l.hardware.limits import Limits, check_commands, limits_of, motion_torque
from t2l.names import is_plain
from t2l.recordings.checks import LEAST_DURATION_S, LEAST_SAMPLES
from t2l.recordings.keys import checked
from t2l.recordings.per_joint import per_joint
from t2l.robots import make_robot
from t2l.typed import AsTuple, Integer, Number, Typed, describe, refuse, suggestion

ADDRESS_ALLOWED = f"{SIMULATION}, or the address of an FR3"
# aiofranka keeps every cycle of a recording in memory, 0.2 kB each
LONGEST_S = 600
# twice the study's grid; checking so many of the longest recordings takes seconds
MOST_GAINS = 100
MOST_FREQUENCIES = 100


def _address(value: str) -> str:
    if not value.strip() or value != value.strip():
        raise refuse(ADDRESS_ALLOWED)
    return value


def _prefix(value: str) -> str:
    # the gains follow
    if value and not is_plain(f"{value}_kp100_kd100"):
        raise refuse("letters, digits, _, - and ., as it begins the names of files")
    return value


def _control_rate(value: Any) -> Any:
    if value != CONTROL_RATE_HZ:
        raise refuse(f"{CONTROL_RATE_HZ}, the rate of aiofranka")
    return value


class PlanFile(Typed):
    """A configuration of recordings as it is written."""

    address: Annotated[str, AfterValidator(_address), Field(description=ADDRESS_ALLOWED)]
    name: Annotated[str, AfterValidator(_prefix)] = ""
    start_rad: per_joint(one_for_all=False) = Field(None)
    gains: Annotated[Any, Field(description="kp and kd, or a list of such pairs")]
    excitation: Annotated[dict[str, Any], Field(description="the keys of an excitation")]
    command_rate_hz: Annotated[Number, Field(gt=0)] = 50.0
    control_rate_hz: Annotated[Any, BeforeValidator(_control_rate)] = CONTROL_RATE_HZ
    notes: str = ""


class Gains(Typed):
    """A pair of gains as it is written."""

    kp: Annotated[per_joint(above=0, unit="N·m/rad"), Field(description="numbers, in N·m/rad")]
    kd: Annotated[per_joint(above=0, unit="N·m·s/rad"), Field(description="numbers, in N·m·s/rad")]


class Excitation(Typed):
    """What every kind of motion has."""

    kind: str
    amplitude_rad: Annotated[
        per_joint(at_least=0, unit="rad"), Field(description="numbers, in rad")
    ]
    duration_s: Annotated[
        Number, Field(ge=LEAST_DURATION_S, le=LONGEST_S, description="a number, in s")
    ]
    ramp_s: Annotated[Number, Field(gt=0)] | None = None


Frequency = Annotated[Number, Field(gt=0, description="a number above 0, in Hz")]


class Sine(Excitation):
    """One frequency for each joint."""

    frequency_hz: Annotated[
        per_joint(above=0, unit="Hz"), Field(description="numbers above 0, in Hz")
    ]


class Chirp(Excitation):
    """A frequency that changes."""

    from_hz: Frequency
    to_hz: Frequency


class Multisine(Excitation):
    """Several frequencies at once."""

    frequencies_hz: Annotated[
        tuple[Frequency, ...],
        AsTuple,
        Field(
            min_length=1,
            max_length=MOST_FREQUENCIES,
            description="a list of numbers above 0, in Hz",
        ),
    ]
    seed: Annotated[Integer, Field(ge=0, description="an integer from 0 up")]


KINDS: dict[str, type[Excitation]] = {"sine": Sine, "chirp": Chirp, "multisine": Multisine}


@dataclass(frozen=True)
class Setting:
    """Gains of one recording: its name, kp N·m/rad (njoint,), kd N·m·s/rad (njoint,)."""

    name: str
    kp: np.ndarray
    kd: np.ndarray


@dataclass(frozen=True)
class Plan:
    """A checked configuration of recordings.

    Attributes:
        path: the configuration.
        address: of the robot, or `SIMULATION`.
        settings: one for each recording.
        q_des: rad, (n, njoint), the commands of every recording, one every 1/`command_rate_hz` s.
        command_rate_hz: of the commands.
        limits: that the commands were checked against, and the motion will be.
        notes: kept with every recording.
    """

    path: Path
    address: str
    settings: tuple[Setting, ...]
    q_des: np.ndarray
    command_rate_hz: float
    limits: Limits
    notes: str

    @property
    def duration_s(self) -> float:
        """Of one recording."""
        return len(self.q_des) / self.command_rate_hz


def read_plan(path: Path | str) -> Plan:
    """Read a configuration and check all that it asks of the robot.

    Raises:
        RecordingError: a key is missing, unknown or wrong, or a motion is beyond a limit.
    """
    path = Path(path)
    robot = make_robot("fr3_hand")
    limits = limits_of(robot)
    njoint = len(limits.joints)
    content = read_yaml(path, "a configuration of recordings")
    found = checked(PlanFile, content, path, context=njoint)
    rate = float(found.command_rate_hz)
    if rate > CONTROL_RATE_HZ / 2:
        raise RecordingError(
            path, "key command_rate_hz", f"{rate:g}", f"up to {CONTROL_RATE_HZ // 2}"
        )
    start = robot.home if found.start_rad is None else found.start_rad
    settings = _settings(found, path, njoint)
    offsets, description = _excite(found, path, njoint, rate)
    q_des = start + offsets
    motion = motion_torque(q_des, rate, limits)
    for setting in settings:
        check_commands(q_des, rate, setting.kp, motion, limits, path, setting.name)
    return Plan(
        path=path,
        address=found.address,
        settings=settings,
        q_des=q_des,
        command_rate_hz=rate,
        limits=limits,
        notes="; ".join(filter(None, (found.notes, description))),
    )


def _settings(found: PlanFile, path: Path, njoint: int) -> tuple[Setting, ...]:
    value = found.gains
    listed = value if isinstance(value, list) else [value]
    allowed = f"kp and kd, or a list of such pairs, at most {MOST_GAINS}"
    if not listed:
        raise RecordingError(path, "key gains", "an empty list", allowed)
    if len(listed) > MOST_GAINS:
        raise RecordingError(path, "key gains", f"{len(listed)} pairs", allowed)
    settings: dict[str, Setting] = {}
    for number, pair in enumerate(listed):
        where = f"gains[{number}]." if isinstance(value, list) else "gains."
        gains = checked(Gains, pair, path, where, context=njoint)
        kp, kd = gains.kp, gains.kd
        uniform = (kp == kp[0]).all() and (kd == kd[0]).all()
        name = Cell(float(kp[0]), float(kd[0])).name if uniform else f"setting{number + 1}"
        name = f"{found.name}_{name}" if found.name else name
        if name in settings:
            raise RecordingError(path, "key gains", f"{name} twice", "different pairs")
        settings[name] = Setting(name, kp, kd)
    return tuple(settings.values())


def _excite(found: PlanFile, path: Path, njoint: int, rate: float) -> tuple[np.ndarray, str]:
    """Offsets from the start, (n, njoint), and the excitation in words."""
    kind = found.excitation.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        shown = f"{describe(kind)}{suggestion(kind, list(KINDS)) if kind else ''}"
        raise RecordingError(path, "key excitation.kind", shown, ", ".join(KINDS))
    part: Any = checked(KINDS[kind], found.excitation, path, "excitation.", context=njoint)

    def refused(key: str, shown: str, allowed: str) -> RecordingError:
        return RecordingError(path, f"key excitation.{key}", shown, allowed)

    def check_frequencies(key: str, frequencies: Any) -> None:
        if np.max(frequencies) > rate / 2:
            raise refused(
                key, f"{np.max(frequencies):g}", f"up to {rate / 2:g}, half of command_rate_hz"
            )

    if not part.amplitude_rad.any():
        raise refused("amplitude_rad", "0 for every joint", "above 0 for at least one")
    duration = float(part.duration_s)
    # what could not be read back is not recorded
    if duration < LEAST_SAMPLES / rate:
        raise refused("duration_s", f"{duration:g}", f"a number from {LEAST_SAMPLES / rate:g} up")
    ramp = min(1.0, duration / 4) if part.ramp_s is None else float(part.ramp_s)
    if 2 * ramp > duration:
        raise refused("ramp_s", f"{ramp:g}", f"up to {duration / 2:g}, half of duration_s")
    time = np.arange(round(duration * rate) + 1) / rate
    if kind == "sine":
        check_frequencies("frequency_hz", part.frequency_hz)
        offsets = excitation.sine(time, part.amplitude_rad, part.frequency_hz)
    elif kind == "chirp":
        for key in ("from_hz", "to_hz"):
            check_frequencies(key, getattr(part, key))
        offsets = excitation.chirp(
            time, part.amplitude_rad, float(part.from_hz), float(part.to_hz), duration
        )
    else:
        check_frequencies("frequencies_hz", part.frequencies_hz)
        offsets = excitation.multisine(
            time, part.amplitude_rad, [float(f) for f in part.frequencies_hz], part.seed
        )
    offsets = offsets * excitation.envelope(time, time[-1], ramp)[:, None]
    said = {key: value for key, value in found.excitation.items() if value is not None}
    return offsets, "excitation: " + ", ".join(f"{key} {value}" for key, value in said.items())
