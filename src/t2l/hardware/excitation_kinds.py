"""The `excitation` of a plan: its keys, and the offsets from the start that they ask for."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from t2l.errors import RecordingError
from t2l.hardware import excitation
from t2l.recordings.checks import LEAST_DURATION_S, LEAST_SAMPLES
from t2l.recordings.keys import checked
from t2l.recordings.per_joint import per_joint
from t2l.typed import AsTuple, Integer, Number, Typed, describe, suggestion

# aiofranka keeps every cycle of a recording in memory, 0.2 kB each
LONGEST_S = 600
MOST_FREQUENCIES = 100


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
    # of the keys that hold frequencies
    frequency_keys: ClassVar[tuple[str, ...]]

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """(n, njoint) rad at `time` (n,) s, without ramps."""
        raise NotImplementedError


Frequency = Annotated[Number, Field(gt=0, description="a number above 0, in Hz")]


class Sine(Excitation):
    """One frequency for each joint."""

    frequency_hz: Annotated[
        per_joint(above=0, unit="Hz"), Field(description="numbers above 0, in Hz")
    ]
    frequency_keys = ("frequency_hz",)

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        return excitation.sine(time, self.amplitude_rad, self.frequency_hz)


class Chirp(Excitation):
    """A frequency that changes."""

    from_hz: Frequency
    to_hz: Frequency
    frequency_keys = ("from_hz", "to_hz")

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        limits = float(self.from_hz), float(self.to_hz)
        return excitation.chirp(time, self.amplitude_rad, *limits, float(self.duration_s))


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
    frequency_keys = ("frequencies_hz",)

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        frequencies = [float(frequency) for frequency in self.frequencies_hz]
        return excitation.multisine(time, self.amplitude_rad, frequencies, self.seed)


class Triangle(Excitation):
    """Constant speed between reversals."""

    frequency_hz: Annotated[
        per_joint(above=0, unit="Hz"), Field(description="numbers above 0, in Hz")
    ]
    frequency_keys = ("frequency_hz",)

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        return excitation.triangle(time, self.amplitude_rad, self.frequency_hz)


class PointToPoint(Excitation):
    """Minimum-jerk moves with stops."""

    move_s: Annotated[Number, Field(gt=0, description="a number above 0, in s")]
    dwell_s: Annotated[Number, Field(ge=0, description="a number from 0 up, in s")]
    frequency_keys = ()

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        times = float(self.move_s), float(self.dwell_s)
        return excitation.point_to_point(time, self.amplitude_rad, *times)


class Hold(Excitation):
    """A pose away from the start, which the ramps lead to and from."""

    frequency_keys = ()

    def offsets(self, time: np.ndarray) -> np.ndarray:
        """See `Excitation.offsets`."""
        return np.tile(self.amplitude_rad, (len(time), 1))


KINDS: dict[str, type[Excitation]] = {
    "sine": Sine,
    "chirp": Chirp,
    "multisine": Multisine,
    "triangle": Triangle,
    "point_to_point": PointToPoint,
    "hold": Hold,
}


def offsets(
    section: Mapping[str, Any],
    path: Path,
    njoint: int,
    rate: float,
    prefix: str = "excitation.",
) -> tuple[np.ndarray, str]:
    """Offsets from the start, (ncommand, njoint) rad at `rate` Hz, and the excitation in words.

    Args:
        prefix: of its keys in messages.

    Raises:
        RecordingError: a key of it is missing, unknown or wrong.
    """
    kind = section.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        shown = f"{describe(kind)}{suggestion(kind, list(KINDS)) if kind else ''}"
        raise RecordingError(path, f"key {prefix}kind", shown, ", ".join(KINDS))
    part = checked(KINDS[kind], section, path, prefix, context=njoint)

    def refused(key: str, shown: str, allowed: str) -> RecordingError:
        return RecordingError(path, f"key {prefix}{key}", shown, allowed)

    if not part.amplitude_rad.any():
        raise refused("amplitude_rad", "0 for every joint", "above 0 for at least one")
    duration = float(part.duration_s)
    # what could not be read back is not recorded
    if duration < LEAST_SAMPLES / rate:
        raise refused("duration_s", f"{duration:g}", f"a number from {LEAST_SAMPLES / rate:g} up")
    ramp = min(1.0, duration / 4) if part.ramp_s is None else float(part.ramp_s)
    if 2 * ramp > duration:
        raise refused("ramp_s", f"{ramp:g}", f"up to {duration / 2:g}, half of duration_s")
    for key in part.frequency_keys:
        if (highest := np.max(getattr(part, key))) > rate / 2:
            raise refused(key, f"{highest:g}", f"up to {rate / 2:g}, half of command_rate_hz")
    time = np.arange(round(duration * rate) + 1) / rate
    ramped = part.offsets(time) * excitation.envelope(time, time[-1], ramp)[:, None]
    said = {key: value for key, value in section.items() if value is not None}
    return ramped, "excitation: " + ", ".join(f"{key} {value}" for key, value in said.items())
