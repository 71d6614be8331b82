"""What a policy is. Nothing here loads torch, and a policy need not either."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from t2l.typed import Typed

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Pictures:
    """What cameras saw at n steps, in a store that many episodes share and that nothing copies.

    Attributes:
        store: (N, ncamera, height, width, 3) uint8.
        frames: (n,) indices of the steps' pictures in `store`.
    """

    store: np.ndarray
    frames: np.ndarray


@dataclass(frozen=True, eq=False)
class Episode:
    """A demonstration at the policy's rate.

    Attributes:
        observation: (n, nobs) float32.
        action: (n, nact) float32.
        robot_size: how many numbers of an observation, its first, are the robot's own; the others
            tell its environment.
        pictures: of the n steps, for policies that see some.
    """

    observation: np.ndarray
    action: np.ndarray
    robot_size: int = 0
    pictures: Pictures | None = None


@dataclass(frozen=True)
class TrainingSet:
    """What one policy is trained on, and the seed of its random numbers."""

    training: Sequence[Episode]
    validation: Sequence[Episode]
    seed: int


class Policy(ABC):
    """From the latest observations to the next actions, of n episodes at once.

        a[k … k + chunk − 1] = π(o[k − history + 1 … k])

    What an action means is said elsewhere (`t2l.actions`); its scale there, α, the policy carries
    with it. A policy has no other memory than its
    history, so that many episodes may share one; whoever acts by it decides how much of a chunk is
    carried out before it is asked again.

    Attributes:
        name: what checkpoints call the class.
        observation_size, action_size: nobs and nact.
        history: observations that it sees.
        chunk: actions that it answers with.
        action_scale: α, one number or (nact,).
        sees_pictures: whether it can be told to look at pictures beside its observations.
    """

    name: str
    observation_size: int
    action_size: int
    history: int
    chunk: int
    action_scale: np.ndarray | float = 1.0
    sees_pictures: bool = False

    @abstractmethod
    def act(self, history: np.ndarray, pictures: np.ndarray | None = None) -> np.ndarray:
        """Action chunks (n, chunk, nact) for histories (n, history, nobs), the latest last.

        Args:
            pictures: (n, ncamera, height, width, 3) uint8 of the latest observation, for a policy
                that was trained with such; others are asked without, and need no such argument.
        """

    def action(self, observation: np.ndarray) -> np.ndarray:
        """Actions (n, nact) for observations (n, nobs), of a policy that sees no earlier ones."""
        return self.act(observation[:, None])[:, 0]

    @abstractmethod
    def tensors(self) -> dict[str, np.ndarray]:
        """All that it has learned, by name."""

    @abstractmethod
    def metadata(self) -> dict[str, Any]:
        """What else it takes to make it again, such as its sizes, as JSON has it."""

    @classmethod
    @abstractmethod
    def restored(cls, tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> Self:
        """The policy of which these are `tensors` and `metadata`.

        Raises:
            ValueError: they are of none, or do not fit each other.
        """


class ClonedPolicy(Policy):
    """A policy that trains itself on demonstrated episodes.

    Attributes:
        name: what configurations write as `training.policy` too.
        settings: what else they may write under `training`: the only place of its defaults.
        chunk_setting: which of them says `chunk`, if one does.
        picture_settings: those of them that say something of pictures alone, zero by default.
        packages: to import, without which it is not to be had.
        needs: parts of an observation that it cannot do without: `robot`, `environment`,
            `pictures`.
    """

    settings: type[Typed]
    chunk_setting: str | None = None
    picture_settings: tuple[str, ...] = ()
    packages: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()

    @classmethod
    @abstractmethod
    def fit(
        cls,
        training: Sequence[Episode],
        validation: Sequence[Episode],
        settings: Typed,
        seed: int,
        threads: int = 1,
    ) -> "tuple[Self, pd.DataFrame]":
        """Train from scratch; the same seed on the same machine gives the same policy.

        Args:
            training: episodes to learn from, at least one. All have pictures, of one store, or
                none has.
            validation: episodes to judge by, at least one; likewise, of the same store.
            settings: an instance of `settings`.
            threads: of the processor that training may use.

        Returns:
            The policy, and one row an epoch: `epoch`, `training_loss`, `validation_loss`, and what
            else there is to say. The validation loss is that of acting on `validation`.
        """

    @classmethod
    def fit_side_by_side(
        cls, sets: Sequence[TrainingSet], settings: Typed, threads: int = 1
    ) -> "list[tuple[Self, pd.DataFrame]]":
        """Train a policy on each set; a class that can, trains them all at once on a GPU."""
        return [cls.fit(s.training, s.validation, settings, s.seed, threads) for s in sets]
