"""Sections of sim-to-real transfer."""

from typing import Annotated, Literal, get_origin

from pydantic import ConfigDict, Field, create_model

from t2l.config.models.actions import RelativeActions
from t2l.config.models.grid import CompliantUpTo, Dampings, Grid, OverdampedFrom, Stiffnesses
from t2l.config.quantities import LARGEST_SEED, Bounds, Gain, Given, Point, Positive, Text
from t2l.hardware import BACKENDS
from t2l.rl.settings import JOURNAL, LOGARITHMIC
from t2l.typed import Integer, Name, Number, Typed, Unique


class RecordingGrid(Grid):
    """Of transfer."""

    kp: Stiffnesses = [16, 128, 512]
    kd: Dampings = [1, 8, 24]
    compliant_up_to_kp: CompliantUpTo = 128
    overdamped_from_kd: OverdampedFrom = 8


class GivenScale(Typed):
    """Action scales that are known for a cell."""

    kp: Gain = Field(description="stiffness of the cell, N·m/rad")
    kd: Gain = Field(description="damping of the cell, N·m·s/rad")
    rad: Annotated[list[Positive], Field(min_length=1, max_length=100)] = Field(
        description="the action scale of each group of joints, rad"
    )


class Condition(Typed):
    """An entry of `sim_to_real.conditions`; see `t2l.rl.condition.Condition`."""

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


class ReinforcementLearning(Typed):
    """In the identified simulator."""

    algorithm: Name = Field(
        "ppo", description="`ppo`, with the hyper-parameters of the study; or one of yours"
    )
    # simulations side by side, 100 kB each
    environments: Integer = Field(
        512, ge=4, le=16_384, description="arms that are simulated side by side"
    )
    updates: Integer = Field(
        40,
        ge=1,
        le=100_000,
        description="updates of the policy at most, each after 24 steps of every environment; the "
        "study has 1000",
    )
    evaluate_every: Integer = Field(
        10, ge=1, le=100_000, description="updates between evaluations; the best policy is kept"
    )
    enough: Annotated[Number | None, Given] = Field(
        None,
        gt=0,
        le=1,
        description="success rate, with every constraint kept, at which training ends; without "
        "this key it never ends early, as in the study",
    )
    observation_noise_rad: Number = Field(
        0.01,
        ge=0,
        le=0.1,
        description="uniform noise on the positions that are observed while training, rad, up to "
        "so much either way; 0.01 is that of IsaacLab's templates",
    )
    observation_noise_rad_s: Number = Field(
        0.01, ge=0, le=1, description="the same on velocities, rad/s"
    )
    clip_actions: bool = Field(
        True,
        description="whether actions are kept between -1 and 1, in training and on the robot; "
        "IsaacLab's templates, and so the study, do not",
    )
    shared_network: bool = Field(
        True, description="whether policy and value share their hidden layers, as in the study"
    )
    horizon_s: Number = Field(
        8, ge=1, le=60, description="length of an episode, and of a rollout on the robot, s"
    )
    seed: Integer = Field(
        42, ge=0, le=LARGEST_SEED, description="seed of training; 42 is the study's"
    )


class Tuning(Typed):
    """By Optuna."""

    # Optuna reads all of a study's trials again for each
    trials: Integer = Field(
        2,
        ge=1,
        le=10_000,
        description="trials of a study; more of them continue it, and so does a run after a kill",
    )
    startup: Integer = Field(
        1,
        ge=1,
        le=10_000,
        description="trials before sampler and pruner judge by earlier ones; a trial whose "
        "objective is below 0.1 half-way, which only breaking the limits can bring about, is ended "
        "too, once another is complete",
    )
    workers: Integer = Field(1, ge=1, le=1_000, description="jobs that share a study")
    prune: bool = Field(
        True, description="whether hopeless trials are ended; the study completes every one"
    )
    updates: Annotated[Integer | None, Given] = Field(
        None,
        ge=1,
        le=100_000,
        description="updates of a trial's training; without this key, as many as "
        "`reinforcement_learning.updates`",
    )
    storage: Text = Field(
        JOURNAL,
        description="`journal`: a file beside the results of the cell; or the URL of a database "
        "that all workers reach",
    )
    space: Literal["logarithmic", "study"] = Field(
        LOGARITHMIC,
        description="`logarithmic`: each group of joints has a scale of its own, and the first "
        "trial is a formula's guess; `study`: the scale of the first group is uniform, that of the "
        "wrist a uniform share of it, and nothing is guessed",
    )
    action_scale: Bounds = Field(
        [0.002, 5.0],
        description="bounds of the action scales, rad; of the first group of joints with `study`",
    )
    reward_weights: dict[Text, Bounds] = Field(
        {"position": [0.5, 8.0], "orientation": [0.1, 2.0]},
        description="bounds of those weights of the end-effector task's reward that are tuned, by "
        "name",
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

    `t2l.stats.decision` applies it.
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
