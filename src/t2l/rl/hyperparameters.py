"""The hyper-parameters of PPO: the study's tables of App. E, a column a kind of task."""

from collections.abc import Mapping
from dataclasses import dataclass

from t2l.errors import ConfigurationError
from t2l.tasks import Rewarded

# shared by all columns
GAMMA, LAMBDA = 0.99, 0.95
EPOCHS = 5
CLIP, GRADIENT_NORM = 0.2, 1.0


@dataclass(frozen=True)
class Hyperparameters:
    """A column.

    Attributes:
        layers: hidden, of ELU units.
        learning_rate: the first; it is adapted to the KL divergence.
        target_kl: that it is adapted to.
        rollout_steps: of every environment between updates.
        minibatches: of an epoch.
        entropy, value: coefficients of the loss.
        min_log_std: of the policy's spread.
        normalised: whether observations, and returns by their spread, are normalised.
    """

    layers: tuple[int, ...]
    learning_rate: float = 1e-3
    target_kl: float = 0.01
    rollout_steps: int = 24
    minibatches: int = 4
    entropy: float = 0.01
    value: float = 1.0
    min_log_std: float = -3.0
    normalised: bool = True


REACH = Hyperparameters((64, 64))
COLUMNS: Mapping[str, Hyperparameters] = {
    "reach": REACH,
    "lift": Hyperparameters((256, 128, 64)),
    "drawer": Hyperparameters(
        (256, 128, 64), 5e-4, 0.008, 96, 96, entropy=0.001, value=2.0, min_log_std=-20.0,
        normalised=False,
    ),
    "g1": Hyperparameters(
        (256, 128, 128), entropy=0.008, min_log_std=-20.0, normalised=False
    ),
    # the study has no column for a hand: IsaacLab's, with what all columns share
    "hand": Hyperparameters(
        (512, 256, 128), 5e-4, 0.016, 24, 12, entropy=0.002, value=2.0, min_log_std=-20.0
    ),
}  # fmt: skip


def of_task(task: Rewarded) -> Hyperparameters:
    """The column that a task names.

    Raises:
        ConfigurationError: there is no such column.
    """
    if task.hyperparameters not in COLUMNS:
        raise ConfigurationError(
            f"hyperparameters of {task.name}: found {task.hyperparameters!r}; allowed: "
            f"{', '.join(COLUMNS)}"
        )
    return COLUMNS[task.hyperparameters]
