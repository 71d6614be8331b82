"""A search of gains and action scale together: of `t2l tune`, and of `learning.gain_searches`."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.models.actions import RelativeActions
from t2l.config.quantities import LARGEST_SEED, Bounds, Given, Paths, Positive, Text
from t2l.typed import Integer, Name, Number, Typed, Unique


class GainSearchEntry(Typed):
    """See `t2l.rl.gain_search`."""

    kp: Bounds = Field(
        description="lowest and highest stiffness, N·m/rad, or a factor on a robot's own"
    )
    kd: Bounds = Field(description="lowest and highest damping, N·m·s/rad, likewise")
    action_scale: Bounds = Field([0.002, 5.0], description="bounds of the action scales, rad")
    trials: Integer = Field(
        30, ge=1, le=10_000, description="trials in all; more of them continue a search"
    )
    startup: Integer = Field(
        10, ge=1, le=10_000, description="trials at random, before the others learn from them"
    )
    limits: Annotated[
        list[Literal["position", "velocity", "torque", "torque_rate"]],
        Field(max_length=4),
        Unique,
    ] = Field(
        ["velocity", "torque"],
        description="limits of the robot that a policy has to keep, see `tuning`",
    )
    least_success: Number = Field(
        0.5, ge=0, le=1, description="share of episodes that a trial of the front succeeds in"
    )
    again: Integer = Field(
        1, ge=0, le=100, description="trainings of each trial of the front from other seeds"
    )
    actions: RelativeActions = Field(
        default_factory=RelativeActions, description="what the output of the policy means"
    )
    policy_rate_hz: Positive = Field(50.0, le=1000, description="rate of the policy, Hz")
    rate_hz: Positive = Field(
        200.0, le=10_000, description="rate of the physics, Hz, a multiple of the policy's"
    )
    control_rate_hz: Positive = Field(
        1000.0,
        le=100_000,
        description="rate of the robot's own loop, Hz, at which gains must be stable; recordings "
        "have their own",
    )
    horizon_s: Number = Field(5.0, ge=0.1, le=60, description="length of an episode, s")
    # simulations side by side, 100 kB each
    environments: Integer = Field(
        512, ge=4, le=16_384, description="robots that are simulated side by side"
    )
    updates: Integer = Field(40, ge=1, le=100_000, description="updates of each policy")
    evaluate_every: Integer = Field(
        10, ge=1, le=100_000, description="updates between evaluations; the best policy is kept"
    )
    workers: Integer = Field(
        1, ge=1, le=1_000, description="trials at once on a GPU; jobs that share a search"
    )
    seed: Integer = Field(0, ge=0, le=LARGEST_SEED, description="seed of the search")


class GainSearchOfTask(GainSearchEntry):
    """An entry of `learning.gain_searches`."""

    task: Name = Field(description="name of a file in `config/tasks/`, of a task with a reward")
    recordings: Annotated[Paths | None, Given] = Field(
        None, description="recordings of the real robot, or folders, for a twin of it"
    )
    model: Annotated[Text | None, Given] = Field(
        None, description="the twin, a `model.yaml` of `t2l explain`; together with `recordings`"
    )
