"""The section of decoupling stiffness from gains."""

from typing import Annotated

from pydantic import Field

from t2l.config.models.actions import RelativeActions
from t2l.config.quantities import Gain, Given, Positive
from t2l.typed import Integer, Name, Number, Typed


class Pairing(Typed):
    """An entry of `decoupling.pairings`; see `t2l.study.decoupling.pairing.Pairing`."""

    name: Name = Field(description="name of a folder in `results/STUDY/decoupling/`")
    kp: Gain = Field(description="stiffness Kp, N·m/rad")
    kd: Gain = Field(description="damping Kd, N·m·s/rad")
    actions: RelativeActions = Field(
        default_factory=RelativeActions,
        description="what the output of the policy, between -1 and 1, means",
    )
    lambda_rad2: Positive = Field(
        description="λ of the reward 1 − tanh(‖q − g‖² / λ) − α ‖Δa‖², rad²"
    )
    change: Number = Field(0.0, ge=0, description="α of that reward")
    tolerance_rad: Annotated[Positive | None, Given] = Field(
        None,
        le=1,
        description="how close the pose is held, in place of the task's `tolerance_rad`; "
        "√λ is where the reward has lost three quarters",
    )


class Decoupling(Typed):
    """Of policies that hold a pose."""

    task: Name = Field(
        "pose_hold", description="name of a file in `config/tasks/`, of the kind `pose_hold`"
    )
    pairings: Annotated[list[Pairing], Field(min_length=1, max_length=20)] = Field(
        [
            Pairing(name="soft_arm_trained_stiff", kp=16, kd=8, lambda_rad2=0.01),
            Pairing(name="stiff_arm_trained_soft", kp=512, kd=24, lambda_rad2=1.0, change=0.1),
        ],
        description="gains, and the reward that a policy on top of them is trained by; the table "
        "compares each with the last",
    )
    torque_share: Number = Field(
        0.4,
        gt=0,
        le=1,
        description="action scales are such that a full action asks for this share of the torque "
        "limit",
    )
    # a job each
    seeds: Integer = Field(3, ge=1, le=100, description="trainings of each pairing")
    updates: Integer = Field(300, ge=1, le=100_000, description="updates of the policy")
    evaluate_every: Integer = Field(
        10, ge=1, le=100_000, description="updates between measurements of the stiffness"
    )
    # simulations side by side, 100 kB each
    directions: Integer = Field(
        64, ge=1, le=10_000, description="forces of a measurement, in random directions"
    )
    force_n: Positive = Field(10.0, le=1000, description="size of each, N")
    hold_s: Number = Field(2.0, ge=0.1, le=60, description="how long each is held, s")
