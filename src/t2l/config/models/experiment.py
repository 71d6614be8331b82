"""Sections that say what is transferred, and what a study of transfer is to decide."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.models.actions import RelativeActions
from t2l.config.quantities import Gain, Positive
from t2l.typed import Integer, Name, Number, Typed, Unique


class GivenScale(Typed):
    """Action scales that are known for a cell."""

    kp: Gain = Field(description="stiffness of the cell, N·m/rad, or a factor on the robot's own")
    kd: Gain = Field(description="damping of the cell, N·m·s/rad, or a factor likewise")
    rad: Annotated[list[Positive], Field(min_length=1, max_length=100)] = Field(
        description="the action scale of each group of joints, rad"
    )


class Condition(Typed):
    """An entry of `sim_to_real.conditions`; see `t2l.rl.problem.Condition`."""

    name: Name = Field(description="name of a folder in `results/STUDY/sim_to_real/`")
    task: Name = Field(description="name of a file in `config/tasks/`, of a task with a reward")
    actions: RelativeActions = Field(
        default_factory=RelativeActions,
        description="what the output of the policy, between -1 and 1, means",
    )
    policy_rate_hz: Number = Field(
        50.0,
        gt=0,
        ge=1,
        le=100,
        description="rate of the policy, Hz, a divisor of 100 and of `identification.rate_hz`",
    )
    randomisation: Number = Field(
        0.0,
        ge=0,
        lt=1,
        description="fraction by which parameters vary between environments while training",
    )
    action_scales: Annotated[list[GivenScale], Field(max_length=1000)] = Field(
        [],
        description="action scales that are known: with them nothing is searched, and the "
        "condition has these cells alone",
    )


class SimToReal(Typed):
    """What is transferred."""

    cells: Literal["all", "corners_and_centre"] = Field(
        "corners_and_centre", description="which cells of `recording_grid` are run"
    )
    conditions: Annotated[list[Condition], Field(max_length=100)] = Field(
        [
            Condition(name="joint_reach", task="joint_reach"),
            Condition(name="joint_reach_100_hz", task="joint_reach", policy_rate_hz=100),
        ],
        description="under what policies are trained and deployed; the figures show trajectories "
        "and trials of the first",
    )
    # a job each to train and to deploy, in every cell of every condition
    seeds: Integer = Field(
        3,
        ge=1,
        le=100,
        description="policies of each cell and condition, trained from different seeds with the "
        "chosen action scales; standard errors are clustered by cell",
    )


class CellEntry(Typed):
    """A cell."""

    kp: Gain = Field(description="stiffness, N·m/rad")
    kd: Gain = Field(description="damping, N·m·s/rad")


class RobotAblation(Typed):
    """The same policies on the virtual robot with one of its effects off at a time."""

    condition: Name = Field(description="name of the condition whose policies are deployed")
    cells: Annotated[list[CellEntry], Field(min_length=1, max_length=1000)] = Field(
        description="cells of the condition"
    )
    effects: Annotated[list[Name], Field(min_length=1, max_length=100), Unique] = Field(
        description="what is off in turn, of the effects that `robot.without` takes"
    )


class TransferDecision(Typed):
    """The rule by which a study of transfer is decided, written before its runs.

    `t2l.study.transfer.decision` applies it.
    """

    condition: Name = Field(description="name of the condition that decides")
    alpha: Number = Field(
        0.05, gt=0, lt=1, description="largest p of each of the rule's three requirements"
    )
    stiff_from_kp: Positive = Field(
        128, description="smallest stiffness of the stiff, overdamped region G^SO, N·m/rad"
    )
    overdamped_from_kd: Positive = Field(8, description="its smallest damping, N·m·s/rad")
    cells: Integer = Field(12, ge=4, le=10_000, description="cells that it takes at least")
    seeds: Integer = Field(3, ge=1, le=100, description="policies of each cell that it takes")
    success: Number = Field(
        0.9,
        ge=0,
        le=1,
        description="a policy with less success in its own simulator is no solution, and left out; "
        "a cell without any is missing",
    )
