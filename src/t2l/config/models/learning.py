"""Sections of learning in identified simulators, and of tuning what is learned with."""

from typing import Annotated, Literal

from pydantic import Field

from t2l.config.quantities import LARGEST_SEED, Bounds, Given, Text
from t2l.rl.settings import JOURNAL, LOGARITHMIC
from t2l.typed import Integer, Name, Number, Switch, Typed


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
        10,
        ge=1,
        le=100_000,
        description="updates between evaluations; the policy with the highest reward is kept, or "
        "the one that is `enough`",
    )
    enough: Annotated[Number | None, Given] = Field(
        None,
        gt=0,
        le=1,
        description="success rate, with every constraint kept, at which training ends; without "
        "this key it never ends early, as in the study",
    )
    limit_s: Annotated[Number | None, Given] = Field(
        None,
        gt=0,
        le=10_000_000,
        description="wall-clock time of a training, s: it ends where one more evaluation would "
        "come later, yet not before the first, so the policy depends on the machine; without this "
        "key there is no limit, as in the study",
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
    clip_actions: Switch = Field(
        True,
        description="whether actions are kept between -1 and 1, in training and on the robot; "
        "IsaacLab's templates, and so the study, do not",
    )
    shared_network: Switch = Field(
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
        "objective is below 0.1 half-way, which only breaking the limits can bring about (with "
        "`solved_at`, little success), is ended too, once another is complete",
    )
    workers: Integer = Field(
        1,
        ge=1,
        le=1_000,
        description="jobs that share a study; of trials side by side, those of a cell at once",
    )
    prune: Switch = Field(
        True, description="whether hopeless trials are ended; the study completes every one"
    )
    updates: Annotated[Integer | None, Given] = Field(
        None,
        ge=1,
        le=100_000,
        description="updates of a trial's training; without this key, as many as "
        "`reinforcement_learning.updates`",
    )
    solved_at: Annotated[Number | None, Given] = Field(
        None,
        gt=0,
        le=1,
        description="the task before the limits: a trial with less success is ranked by its "
        "success alone, below all others; without this key every trial is ranked by the study's "
        "objective, for which one that keeps the limits is better than one that does not, whatever "
        "it achieves",
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
