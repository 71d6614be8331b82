"""Sections of behaviour cloning."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.models.grid import CompliantUpTo, Dampings, Grid, OverdampedFrom, Stiffnesses
from t2l.config.quantities import Gains
from t2l.typed import Integer, Number, Typed, Unique


class CloningGrid(Grid):
    """Of behaviour cloning."""

    kp: Stiffnesses = [32, 128, 512, 2048]
    kd: Dampings = [2, 8, 32, 128]
    compliant_up_to_kp: CompliantUpTo = 128
    overdamped_from_kd: OverdampedFrom = 32


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


class Training(Typed):
    """Of behaviour cloning."""

    # a minute of 50 Hz is 3000 steps
    history: Integer = Field(
        10, ge=1, le=1_000, description="observations that the policy sees, in policy steps"
    )
    chunk: Integer = Field(10, ge=1, le=1_000, description="actions that it predicts at once")
    latent: Integer = Field(8, ge=1, le=1_000, description="size of the latent")
    # two layers of the widest side by side take 64 MB
    hidden: Annotated[
        list[Annotated[Integer, Field(ge=1, le=4_096)]], Field(min_length=1, max_length=20)
    ] = Field([256, 256, 256], description="widths of the hidden layers of encoder and decoder")
    kl_weight: Number = Field(
        0.01, ge=0, description="weight of the latent's divergence from its prior"
    )
    epochs: Integer = Field(50, ge=1, le=10_000, description="passes over the training episodes")
    # all windows of a thousand demonstrations of 8 s
    batch_size: Integer = Field(256, ge=1, le=400_000, description="windows per gradient step")
    learning_rate: Number = Field(
        1.0e-3, gt=0, le=10, description="peak of a one-cycle schedule of the learning rate"
    )
    weight_decay: Number = Field(1.0e-4, ge=0, le=10, description="weight decay of AdamW")
    observation_noise: Number = Field(
        0.2,
        ge=0,
        le=100,
        description="standard deviation of noise on normalised observations while training; "
        "without it a policy copies the recent past",
    )
    validation_fraction: Number = Field(
        0.1, gt=0, lt=1, description="share of whole demonstrations that are held out"
    )


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
