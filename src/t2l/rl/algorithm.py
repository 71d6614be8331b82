"""What an algorithm of reinforcement learning is; nothing here loads torch."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from t2l.errors import T2LError
from t2l.policies import Policy
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings

if TYPE_CHECKING:
    import pandas as pd

    from t2l.environment.environment import Environment
    from t2l.rl.environments import Environments

# the number of an update, the policy after it, and how that does
Report = Callable[[int, Policy, Evaluation], None]


class TrainingError(T2LError):
    """Training left no policy that can act."""

    @classmethod
    def not_finite(cls, update: int) -> Self:
        """After an update that left numbers that are not."""
        return cls(
            f"training: update {update} left a policy that is not finite; allowed: finite rewards; "
            "try smaller action scales or reward weights"
        )


class TrainingEnded(Exception):  # noqa: N818
    """What a report raises to end its training."""


@dataclass(frozen=True, eq=False)
class Trained:
    """The policy with the highest reward, or the one that was enough.

    Attributes:
        policy: with history 1 and the action scale of its environments.
        history: one row an evaluation: update, steps, seconds, reward a second, success, the
            constraints' shares, objective, and what the algorithm adds.
    """

    policy: Policy
    evaluation: Evaluation
    history: "pd.DataFrame"


class Algorithm(ABC):
    """Learns a policy by trying.

    Attributes:
        name: what configurations write as `reinforcement_learning.algorithm`.
        side_by_side: whether it can train many policies at once.
        resumes: whether its trainings take `unfinished` too, a `t2l.rl.unfinished.Unfinished`:
            where they keep their state now and then, and go on from, to the same policy.
    """

    name: str
    side_by_side = False
    resumes = False

    @abstractmethod
    def train(
        self,
        environments: "Environments",
        judges: "Environments",
        settings: Settings,
        report: Report = lambda update, policy, evaluation: None,
        threads: int = 1,
    ) -> Trained:
        """Train in `environments`, judge in `judges`, which are not staggered.

        `t2l.rl.progress.Progress` judges, reports and keeps the best.

        Args:
            environments: a VecEnv of stable-baselines3; observations (n, nobs), actions (n, nact)
                in [-1, 1].
            settings: how long, and from which seed; the same seed gives the same policy.
            report: called after each evaluation; `TrainingEnded` ends training.
            threads: of the processor that learning may use.

        Raises:
            TrainingError: an update left numbers that are not finite.
        """

    def train_side_by_side(
        self,
        world: "Environment",
        judges: "Environment",
        seeds: Sequence[int],
        settings: Settings,
        reports: Sequence[Report],
    ) -> list[Trained | TrainingError | TrainingEnded]:
        """Train a policy for each generator of a world, if `side_by_side`.

        Args:
            judges: as many trainings, not staggered, that judge the policies of each.
            seeds: of each training.
            settings: of all; its `seed` is not used.
            reports: of each training; one that raises `TrainingEnded` ends that training.

        Returns:
            For each training what `train` gives or raises.
        """
        raise NotImplementedError
