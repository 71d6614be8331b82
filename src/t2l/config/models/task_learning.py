"""The section of tasks that are learned in simulation alone."""

from typing import Annotated

from pydantic import Field

from t2l.config.models.actions import RelativeActions
from t2l.config.models.experiment import CellEntry, GivenScale
from t2l.config.models.gain_search import GainSearchOfTask
from t2l.config.quantities import Given, Positive
from t2l.typed import Integer, Name, Number, Switch, Typed


class LearnedTask(Typed):
    """An entry of `learning.tasks`; see `t2l.rl.alone`."""

    task: Name = Field(description="name of a file in `config/tasks/`, of a task with a reward")
    action_scales: Annotated[list[GivenScale], Field(max_length=1000)] = Field(
        [], description="cells whose action scales are known, and these"
    )
    searched: Annotated[list[CellEntry], Field(max_length=1000)] = Field(
        [],
        description="cells whose action scales are looked for by `tuning.trials` trials; as in the "
        "study, success alone ranks trials of what is not deployed",
    )
    actions: RelativeActions = Field(
        default_factory=RelativeActions,
        description="what the output of the policy, between -1 and 1, means to the joints; a "
        "gripper has one more element, below 0 to close it",
    )
    policy_rate_hz: Positive = Field(50.0, le=1000, description="rate of the policy, Hz")
    rate_hz: Positive = Field(
        200.0, le=10_000, description="rate of the physics, Hz, a multiple of the policy's"
    )
    horizon_s: Number = Field(5.0, ge=0.1, le=60, description="length of an episode, s")
    # simulations side by side, 100 kB each
    environments: Integer = Field(
        512, ge=4, le=16_384, description="robots that are simulated side by side"
    )
    updates: Integer = Field(
        1000, ge=1, le=100_000, description="updates of the policy, see `t2l.rl.hyperparameters`"
    )
    evaluate_every: Integer = Field(
        20,
        ge=1,
        le=100_000,
        description="updates between evaluations; the policy with the highest reward is kept",
    )
    clip_actions: Annotated[Switch | None, Given] = Field(
        None,
        description="whether actions are kept between -1 and 1; without this key, as "
        "`reinforcement_learning.clip_actions`",
    )
    observation_noise_rad: Number = Field(
        0.0, ge=0, le=0.1, description="uniform noise on observed positions while training, rad"
    )
    observation_noise_rad_s: Number = Field(
        0.0, ge=0, le=1, description="the same on velocities, rad/s"
    )


class Learning(Typed):
    """Of tasks that are learned under the gains as they are, and not deployed."""

    tasks: Annotated[list[LearnedTask], Field(max_length=100)] = Field(
        [], description="what is learned; each task once"
    )
    gain_searches: Annotated[list[GainSearchOfTask], Field(max_length=100)] = Field(
        [],
        description="tasks for which gains and action scale are searched together, each once, as "
        "`t2l tune` does",
    )
    # a job each
    seeds: Integer = Field(1, ge=1, le=100, description="policies of each cell")
    episodes: Integer = Field(
        100,
        ge=1,
        le=10_000,
        description="fresh episodes that judge a policy, in MuJoCo on the processor; 100 is the "
        "study's number",
    )
