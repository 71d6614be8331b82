"""How policies are trained and tuned; nothing here loads torch."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from t2l.tasks import Rewarded

# the storage that is a file beside the results
JOURNAL = "journal"


@dataclass(frozen=True)
class Settings:
    """Of training.

    Attributes:
        algorithm: a name in `t2l.rl.registry.ALGORITHMS`.
        environments: that run side by side.
        updates: of the policy, each after some steps of every environment.
        evaluate_every: updates between evaluations, of which the best policy is kept.
        enough: success rate, with every constraint kept, at which training ends.
        seed: the study's is 42.
    """

    algorithm: str
    environments: int
    updates: int
    evaluate_every: int
    enough: float
    seed: int


@dataclass(frozen=True)
class Search:
    """Of tuning.

    Attributes:
        trials: that a study is to have.
        action_scale: bounds of both action scales, rad; searched by their logarithms.
        reward_weights: bounds by name, searched by their logarithms.
        startup: trials before the sampler and the pruner judge by earlier ones.
    """

    trials: int
    action_scale: tuple[float, float]
    reward_weights: Mapping[str, tuple[float, float]]
    startup: int

    @classmethod
    def from_section(cls, section: Mapping[str, Any], task: Rewarded) -> "Search":
        """What the `tuning` section of a checked configuration asks of a task."""
        weights = {k: v for k, v in section["reward_weights"].items() if k in task.tuned}
        return cls(
            trials=section["trials"],
            action_scale=tuple(section["action_scale"]),
            reward_weights={name: tuple(bounds) for name, bounds in weights.items()},
            startup=section["startup"],
        )
