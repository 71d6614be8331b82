"""What `t2l record` is to do: a YAML, checked as a whole, with every command computed."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from t2l.errors import RecordingError
from t2l.gains import Cell
from t2l.measurements import excitation
from t2l.measurements.checks import LEAST_DURATION_S, LEAST_SAMPLES
from t2l.measurements.franka import CONTROL_RATE_HZ, SIMULATION
from t2l.measurements.keys import Keys, describe, read_yaml
from t2l.measurements.limits import Limits, check_commands, fr3_limits
from t2l.robots import fr3

KEYS = (
    "address",
    "name",
    "start_rad",
    "gains",
    "excitation",
    "command_rate_hz",
    "control_rate_hz",
    "notes",
)
COMMON_KEYS = ("kind", "amplitude_rad", "duration_s", "ramp_s")
KIND_KEYS = {
    "sine": ("frequency_hz",),
    "chirp": ("from_hz", "to_hz"),
    "multisine": ("frequencies_hz", "seed"),
}


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
    limits = fr3_limits()
    njoint = len(limits.joints)
    keys = Keys(read_yaml(path, "a configuration of recordings"), path, KEYS)
    address = keys.text("address", allowed=f"{SIMULATION}, or the address of an FR3")
    rate = keys.number("command_rate_hz", above=0, default=50.0)
    if rate > CONTROL_RATE_HZ / 2:
        raise keys.error("command_rate_hz", f"{rate:g}", f"up to {CONTROL_RATE_HZ // 2}")
    if keys.number("control_rate_hz", default=CONTROL_RATE_HZ) != CONTROL_RATE_HZ:
        found = describe(keys.values["control_rate_hz"])
        raise keys.error("control_rate_hz", found, f"{CONTROL_RATE_HZ}, the rate of aiofranka")
    start = keys.each("start_rad", njoint, one_for_all=False, default=list(fr3.HOME))
    settings = _settings(keys, njoint)
    offsets, description = _excite(keys, njoint, rate)
    q_des = start + offsets
    for setting in settings:
        check_commands(q_des, rate, setting.kp, limits, path, setting.name)
    notes = keys.text("notes", default="")
    return Plan(
        path=path,
        address=address,
        settings=settings,
        q_des=q_des,
        command_rate_hz=rate,
        limits=limits,
        notes="; ".join(filter(None, (notes, description))),
    )


def _settings(keys: Keys, njoint: int) -> tuple[Setting, ...]:
    allowed = "kp and kd, or a list of such pairs"
    value = keys.get("gains", allowed)
    prefix = keys.text("name", default="")
    listed = value if isinstance(value, list) else [value]
    if not listed:
        raise keys.error("gains", "an empty list", allowed)
    settings: list[Setting] = []
    for number, pair in enumerate(listed):
        where = f"gains[{number}]." if isinstance(value, list) else "gains."
        part = Keys(pair, keys.path, ("kp", "kd"), where)
        kp = part.each("kp", njoint, above=0, unit="N·m/rad")
        kd = part.each("kd", njoint, above=0, unit="N·m·s/rad")
        uniform = (kp == kp[0]).all() and (kd == kd[0]).all()
        name = Cell(float(kp[0]), float(kd[0])).name if uniform else f"setting{number + 1}"
        name = f"{prefix}_{name}" if prefix else name
        if any(setting.name == name for setting in settings):
            raise keys.error("gains", f"{name} twice", "different pairs")
        settings.append(Setting(name, kp, kd))
    return tuple(settings)


def _excite(keys: Keys, njoint: int, rate: float) -> tuple[np.ndarray, str]:
    """Offsets from the start, (n, njoint), and the excitation in words."""
    every = (*COMMON_KEYS, *(key for known in KIND_KEYS.values() for key in known))
    part = keys.section("excitation", every)
    kind = part.choice("kind", tuple(KIND_KEYS))
    part = keys.section("excitation", (*COMMON_KEYS, *KIND_KEYS[kind]))
    amplitude = part.each("amplitude_rad", njoint, at_least=0, unit="rad")
    if not amplitude.any():
        raise part.error("amplitude_rad", "0 for every joint", "above 0 for at least one")
    # what could not be read back is not recorded
    duration = part.number("duration_s", at_least=max(LEAST_DURATION_S, LEAST_SAMPLES / rate))
    ramp = part.number("ramp_s", above=0, default=min(1.0, duration / 4))
    if 2 * ramp > duration:
        raise part.error("ramp_s", f"{ramp:g}", f"up to {duration / 2:g}, half of duration_s")
    time = np.arange(round(duration * rate) + 1) / rate
    if kind == "sine":
        frequency = part.each("frequency_hz", njoint, above=0)
        _check_frequencies(part, "frequency_hz", frequency, rate)
        offsets = excitation.sine(time, amplitude, frequency)
    elif kind == "chirp":
        ends = [part.number(key, above=0) for key in ("from_hz", "to_hz")]
        for key, end in zip(("from_hz", "to_hz"), ends, strict=True):
            _check_frequencies(part, key, np.array([end]), rate)
        offsets = excitation.chirp(time, amplitude, *ends, duration)
    else:
        frequencies = _frequencies(part, rate)
        offsets = excitation.multisine(time, amplitude, frequencies, _seed(part))
    offsets = offsets * excitation.envelope(time, time[-1], ramp)[:, None]
    return offsets, "excitation: " + ", ".join(
        f"{key} {value}" for key, value in part.values.items()
    )


def _frequencies(part: Keys, rate: float) -> list[float]:
    allowed = "a list of numbers above 0"
    values: Any = part.get("frequencies_hz", allowed)
    if not isinstance(values, list) or not values:
        raise part.error("frequencies_hz", describe(values), allowed)
    frequencies = part.each("frequencies_hz", len(values), above=0)
    _check_frequencies(part, "frequencies_hz", frequencies, rate)
    return frequencies.tolist()


def _check_frequencies(part: Keys, key: str, frequencies: np.ndarray, rate: float) -> None:
    if frequencies.max() > rate / 2:
        raise part.error(
            key, f"{frequencies.max():g}", f"up to {rate / 2:g}, half of command_rate_hz"
        )


def _seed(part: Keys) -> int:
    seed = part.get("seed", "a whole number from 0 up")
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise part.error("seed", describe(seed), "a whole number from 0 up")
    return seed


def check_free(plan: Plan, folder: Path) -> None:
    """Whether the recordings of a plan would replace none that is there.

    Raises:
        RecordingError: one would.
    """
    for setting in plan.settings:
        for suffix in (".csv", ".parquet", ".yaml"):
            path = folder / f"{setting.name}{suffix}"
            if path.exists():
                raise RecordingError(
                    path, "the folder", "this recording", "another folder or name, or to delete it"
                )
