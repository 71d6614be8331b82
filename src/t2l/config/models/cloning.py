"""Sections of behaviour cloning."""

from typing import Annotated, Any, Literal

from pydantic import Field

from t2l.config.models.grid import CompliantUpTo, Dampings, Grid, OverdampedFrom, Stiffnesses
from t2l.config.quantities import Gains, Given, Text
from t2l.policies import chunk_cvae
from t2l.typed import Integer, Name, Number, Typed, Unique

# one to train on, one to judge by
Uses = Annotated[Integer, Field(ge=2, le=5_000)]


class CloningGrid(Grid):
    """Of behaviour cloning."""

    kp: Stiffnesses = [32, 128, 512, 2048]
    kd: Dampings = [2, 8, 32, 128]
    compliant_up_to_kp: CompliantUpTo = 128
    overdamped_from_kd: OverdampedFrom = 32
    subset: Literal["all", "corners_and_centre"] = Field(
        "all", description="which of these cells are run"
    )


class Demonstrations(Typed):
    """Of the expert."""

    # of 8 s and 2 MB each
    count: Integer = Field(
        100, ge=2, le=5_000, description="how many successful demonstrations are recorded"
    )
    max_attempts: Integer = Field(
        200,
        ge=2,
        le=100_000,
        description="attempts after which an expert that falls short gives up and says its rate",
    )
    used: Annotated[Uses | dict[Text, Uses] | None, Given] = Field(
        None,
        description="how many of those that survive retargeting are trained on, the first ones: a "
        "number, or one for each of some cells by its name, such as kp32_kd2; without it all",
    )


class Operator(Typed):
    """Who demonstrates through the controller of a cell."""

    reaction_s: Number = Field(
        0.2, ge=0, le=1, description="from seeing to acting, s; people take 0.15 to 0.25"
    )
    motor_noise: Number = Field(
        0.02,
        ge=0,
        le=0.5,
        description="by how much the end of a movement of one second scatters, in each direction, "
        "as a share of its length",
    )
    crossover_rad_s: Annotated[
        list[Annotated[Number, Field(gt=0, ge=0.01, le=100)]],
        Field(min_length=1, max_length=20),
        Unique,
    ] = Field(
        [1, 2, 3],
        description="how quickly what is seen to be wrong is corrected, rad/s; of several, the "
        "operator takes the one that does best in practice under the gains of the cell",
    )
    practice: Integer = Field(
        16, ge=1, le=500, description="attempts with each of them, which are not kept"
    )


class Retargeting(Typed):
    """To the gains of a cell."""

    policy_rate_hz: Number = Field(
        50,
        gt=0,
        ge=1,
        le=500,
        description="rate of the position commands, Hz, a divisor of the simulation's 500 Hz",
    )
    hold: Literal["mean", "sample"] = Field(
        "mean",
        description="how a held command follows from the 500 Hz commands that it replaces: `mean` "
        "of them keeps the impulse, `sample` of the first lags by half the hold",
    )


class Fidelity(Typed):
    """Where retargeting is validated."""

    kp: Gains = Field([16, 512], description="stiffnesses Kp, N·m/rad")
    kd: Gains = Field([2, 24], description="dampings Kd, N·m·s/rad")
    decimations: Annotated[
        list[Annotated[Integer, Field(ge=1, le=500)]],
        Field(min_length=1, max_length=100),
        Unique,
    ] = Field(
        [1, 5, 10, 15, 20, 25, 30, 40, 50],
        description="for how many timesteps of 2 ms a command is held",
    )
    replays: Integer = Field(
        25, ge=1, description="how many of the demonstrations are replayed each time"
    )


class TrainedPolicy(Typed):
    """What `training` has whatever the policy, whose name decides which other keys there are."""

    policy: Name = Field(
        "chunk_cvae",
        description="`chunk_cvae`, a conditional variational autoencoder of action chunks; "
        "`chunk_transformer`, the same of Transformers; `chunk_regression`, least squares; "
        "`chunk_diffusion`, which denoises chunks; `lerobot_act` and `lerobot_diffusion`, those of "
        "lerobot; or a policy of yours, with its own settings. "
        "The keys below are of the first, unless they name another",
    )
    validation_fraction: Number = Field(
        0.1, gt=0, lt=1, description="share of whole demonstrations that are held out"
    )


class Training(chunk_cvae.Settings, TrainedPolicy):
    """Of the policy, where none of the user's is named."""


class Rollouts(Typed):
    """Of behaviour cloning."""

    # all of a cell run side by side, 100 kB each
    count: Integer = Field(
        100,
        ge=1,
        le=5_000,
        description="closed-loop rollouts of each cell; every cell gets the same held-out starts",
    )
    executed_actions: Integer = Field(
        10,
        ge=1,
        description="actions of each chunk that are carried out before the policy is asked again",
    )


class Variant(Typed):
    """What differs from the nominal."""

    demonstrations: Annotated[dict[Text, Any] | None, Given] = Field(
        None, description="`used` alone: all variants share what was recorded"
    )
    observation: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
    actions: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
    operator: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
    retargeting: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
    training: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
    rollouts: Annotated[dict[Text, Any] | None, Given] = Field(None, description="as at the top")
