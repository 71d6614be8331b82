"""How policies are trained and tuned; nothing here loads torch."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from t2l.gains import Cell
from t2l.seeds import seed_sequence
from t2l.tasks import Rewarded

# the storage that is a file beside the results
JOURNAL = "journal"

# how trials choose action scales
STUDY, LOGARITHMIC = "study", "logarithmic"


@dataclass(frozen=True)
class Settings:
    """Of training; the keys of the section `reinforcement_learning` but `horizon_s`.

    Attributes:
        algorithm: a name in `t2l.rl.registry.ALGORITHMS`.
        environments: that run side by side.
        updates: of the policy, each after some steps of every environment.
        evaluate_every: updates between evaluations; the policy with the highest reward is kept, or
            the one that is `enough`.
        seed: the study's is 42.
        observation_noise_rad, observation_noise_rad_s: uniform, on q and q̇ while training.
        clip_actions: whether actions are kept in [-1, 1].
        shared_network: whether policy and value share their hidden layers.
        enough: success rate, with every constraint kept, at which training ends; None for never.
        limit_s: wall-clock time of a training: it ends where one more evaluation would come later,
            yet not before the first. None for no limit.
    """

    algorithm: str
    environments: int
    updates: int
    evaluate_every: int
    seed: int
    observation_noise_rad: float
    observation_noise_rad_s: float
    clip_actions: bool
    shared_network: bool
    enough: float | None = None
    limit_s: float | None = None

    def of_policy(self, condition: str, cell: Cell, seed: int) -> "Settings":
        """For the policy of a cell and condition that is trained from its seed number `seed`."""
        state = seed_sequence(self.seed, "policy", condition, cell.name, seed).generate_state(1)
        # training adds to it
        return replace(self, seed=int(state[0] >> 1))


@dataclass(frozen=True)
class Search:
    """Of tuning.

    Attributes:
        trials: that a study is to have.
        space: `STUDY` or `LOGARITHMIC`, see `t2l.rl.tuning`.
        action_scale: bounds, rad.
        reward_weights: bounds by name, searched by their logarithms.
        startup: trials before the sampler and the pruner judge by earlier ones.
        prune: whether trials that look hopeless are ended.
        updates: of a trial's training; None for as many as of the training that follows.
        solved_at: see `t2l.rl.results.Evaluation.value`.
    """

    trials: int
    space: str
    action_scale: tuple[float, float]
    reward_weights: Mapping[str, tuple[float, float]]
    startup: int
    prune: bool
    updates: int | None = None
    solved_at: float | None = None

    @classmethod
    def from_section(cls, section: Mapping[str, Any], task: Rewarded) -> "Search":
        """What the `tuning` section of a checked configuration asks of a task."""
        weights = {k: v for k, v in section["reward_weights"].items() if k in task.tuned}
        return cls(
            action_scale=tuple(section["action_scale"]),
            reward_weights={name: tuple(bounds) for name, bounds in weights.items()},
            updates=section.get("updates"),
            solved_at=section.get("solved_at"),
            **{key: section[key] for key in ("trials", "space", "startup", "prune")},
        )
