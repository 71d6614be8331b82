"""Sections of sim-to-real transfer."""

from typing import Annotated, Literal, get_origin

from pydantic import ConfigDict, Field, create_model

from t2l.config.models.grid import CompliantUpTo, Dampings, Grid, OverdampedFrom, Stiffnesses
from t2l.config.quantities import Given, Point, Text
from t2l.hardware import BACKENDS
from t2l.typed import Integer, Number, Typed, Unique


class RecordingGrid(Grid):
    """Of transfer."""

    kp: Stiffnesses = [16, 128, 512]
    kd: Dampings = [1, 8, 24]
    # the study's region: of all splits, this one gives its published means best (section IV-C)
    compliant_up_to_kp: CompliantUpTo = 64
    overdamped_from_kd: OverdampedFrom = 8


class RobotSection(Typed):
    """The robot at the other end; keys that are not here belong to a back end of the user's."""

    model_config = ConfigDict(extra="allow")

    name: Text = Field(
        "fr3", description="its name; every condition's task is a task of this robot"
    )
    backend: Text = Field(
        "virtual",
        description="`virtual`: high-fidelity physics in simulation; `aiofranka`: an FR3, or "
        "aiofranka's simulation of it, in real time; `recorded`: logs from disk, for "
        "identification only (the chain ends there); or one of your own, with its keys",
    )


_Texts = Annotated[list[Text], Field(max_length=100), Unique]


def _written(annotation: type) -> type:
    """What a key of a back end is written as; the one that is named checks it: `t2l.config.robot`.

    The library's back ends take text alone, or lists of it.
    """
    return _Texts if get_origin(annotation) is list else Text


Robot = create_model(
    "Robot",
    __base__=RobotSection,
    __doc__=RobotSection.__doc__,
    **{
        key: (
            Annotated[_written(field.annotation) | None, Given],
            Field(None, description=f"with `{name}`: {field.description}"),
        )
        for name in BACKENDS.known
        for key, field in BACKENDS.find(name).settings.model_fields.items()
    },
)


class Recordings(Typed):
    """The motion that is recorded for identification."""

    # the study's text says 0.1; the commands and the motions that it published are of 0.15
    amplitude_rad: Number = Field(
        0.15, gt=0, le=0.3, description="its amplitude, rad; of a multisine at least"
    )
    duration_s: Number = Field(4, ge=1, le=60, description="how long it is recorded, s")
    excitation: Literal["sine", "multisine"] = Field(
        "sine",
        description="`sine`: the study's, of 0.5 Hz on all joints; `multisine`: many frequencies, "
        "so large that a joint that does not move feels three times `breakaway_nm`, within the "
        "robot's limits",
    )
    highest_hz: Number = Field(
        5.0, ge=1, le=10, description="highest frequency of the multisine, Hz"
    )
    # the published recordings of the FR3: 1.2 N·m in sliding, and 1.3 times that at rest
    breakaway_nm: Number = Field(
        1.5, gt=0, le=1000, description="torque that breaks the joints loose, N·m"
    )


class Identification(Typed):
    """Of the actuators of the training simulator."""

    gains: Literal["known", "free"] = Field(
        "known",
        description="`known`: the gains are those that are commanded, times one scale of torque a "
        "joint; armature, friction and scale are fitted to all cells at once by least squares. "
        "`free`: the study's way, six parameters a joint for each cell alone, by CMA-ES",
    )
    iterations: Integer = Field(
        200, ge=1, le=100_000, description="generations of CMA-ES; rounds of least squares at most"
    )
    # simulations side by side, 100 kB each
    population: Integer = Field(
        32, ge=4, le=10_000, description="simulations in each generation of CMA-ES"
    )
    sigma: Number = Field(
        3.0,
        gt=0,
        le=10,
        description="first standard deviation of CMA-ES, where the range of every parameter is 0 "
        "to 10 (gains by their logarithm)",
    )
    rate_hz: Integer = Field(
        100,
        ge=50,
        le=1000,
        description="rate of the training simulator's physics, Hz, a multiple of 50",
    )


class Deployment(Typed):
    """On the robot."""

    rollouts: Integer = Field(
        30,
        ge=1,
        le=1_000,
        description="rollouts on the robot, and as many in simulation, from the same starts to the "
        "same goals",
    )
    # 0.855 m is the reach of the FR3, 0.333 m the height of its shoulder (its data sheet)
    workspace_lower_m: Point = Field(
        [-0.855, -0.855, 0.02],
        description="lower corner of the box that the flange must stay in, m, in the frame of the "
        "robot's base; the default keeps an arm above its table",
    )
    workspace_upper_m: Point = Field(
        [0.855, 0.855, 1.19],
        description="upper corner of that box, m; the default is the reach of the arm",
    )
