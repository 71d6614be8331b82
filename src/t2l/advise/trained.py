"""Policies that are trained to settle what the predicted order leaves open, one after the other.

Each is cloned from the demonstrations of a task, retargeted to a cell, and tried from starts that
no demonstration had, in the task's simulator. What was found is kept after each, so that an
interrupted run goes on.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from t2l.actions import make_control
from t2l.advise.advice import Advice
from t2l.advise.posterior import Settled, Tried, next_cell, posterior
from t2l.artefacts import write_text
from t2l.bc.rollout import roll_out
from t2l.demos.demonstration import Demonstration
from t2l.demos.replay import replay, successful
from t2l.documents import read_yaml, to_yaml
from t2l.errors import ConfigurationError, ReplayError
from t2l.gains import Cell
from t2l.policies import POLICIES, Episode
from t2l.policies.validation import split
from t2l.seeds import generator, torch_seed
from t2l.sim.batch import TIMESTEP_S
from t2l.tasks import Demonstrated
from t2l.typed import Integer, Number, Typed, check

FILE = "trainings.yaml"
STAGE = "advise"
NO_REPLAY = 0.0  # format: success of a cell under which demonstrations do not survive


@dataclass(frozen=True)
class Recipe:
    """How a policy is made and tried.

    Attributes:
        task: with an expert; demonstrations: of it.
        training: the policy's name, the share held out, and its settings.
        actions: the action space.
        policy_rate_hz: a divisor of the simulation's.
        rollouts: of each policy; executed: actions of a chunk that are carried out.
        threads: of the processor.
    """

    task: Demonstrated
    demonstrations: Sequence[Demonstration]
    training: Mapping[str, Any]
    actions: Mapping[str, Any]
    policy_rate_hz: float
    rollouts: int
    executed: int
    threads: int

    @property
    def decimation(self) -> int:
        """Timesteps of a command."""
        return round(1 / (TIMESTEP_S * self.policy_rate_hz))


class Training(Typed):
    """One policy that was trained."""

    kp: Number
    kd: Number
    seed: Integer
    success: Number
    rollouts: Integer


class Trainings(Typed):
    """trainings.yaml; `of` says what they are of."""

    of: str
    trainings: list[Training]


def trainings_of(
    advice: Advice,
    recipe: Recipe,
    count: int,
    path: Path,
    key: str,
    tell: Callable[[str], None] = lambda said: None,
) -> Settled:
    """Train until there are `count` policies, each where the answer is expected to gain most.

    Args:
        path: where they are kept; those that are there count.
        key: what they are of.

    Raises:
        ConfigurationError: what is kept is of something else.
    """
    cells, left = advice.asked.grid.cells, advice.left
    kept = begun(path, key)
    while True:
        found = believed(advice, kept)
        if len(kept) >= count:
            return found
        cell = cells[next_cell(found.believed, left)]
        seed = sum((one.kp, one.kd) == (cell.kp, cell.kd) for one in kept)
        tell(f"training {len(kept) + 1} of {count}: Kp {cell.kp:g}, Kd {cell.kd:g}")
        success = trained(recipe, cell, seed)
        tell(f"training {len(kept) + 1} of {count}: {100 * success:.0f} % succeed")
        kept = [
            *kept,
            Training(
                kp=cell.kp, kd=cell.kd, seed=seed, success=success, rollouts=recipe.rollouts
            ),
        ]  # fmt: skip
        content = Trainings(of=key, trainings=kept).model_dump(mode="json")
        write_text(to_yaml(content, sort_keys=False), path)


def begun(path: Path, key: str) -> list[Training]:
    """What is kept, nothing if there is no file.

    Raises:
        ConfigurationError: it is of something else.
    """
    if not path.exists():
        return []
    kept = check(Trainings, read_yaml(path, "trainings"))
    if kept.of != key:
        raise ConfigurationError(
            f"{path}: found trainings of {kept.of}; allowed: of {key}, which the task, gains, "
            "--count and --policy-rate make, or another --out"
        )
    return kept.trainings


def believed(advice: Advice, trainings: Sequence[Training]) -> Settled:
    """The success of every cell, by the predicted order and by trainings."""
    pairs = [(cell.kp, cell.kd) for cell in advice.asked.grid.cells]
    tried = [Tried(pairs.index((one.kp, one.kd)), one.success) for one in trainings]
    kp, kd = np.array(pairs).T
    return Settled(tuple(tried), posterior(advice.score, kp, kd, tried))


def trained(recipe: Recipe, cell: Cell, seed: int) -> float:
    """The share of successes of one policy; 0 where demonstrations do not survive retargeting."""
    task = recipe.task
    control = make_control(recipe.actions, cell, task.robot, task.model)
    replays = replay(
        task, recipe.demonstrations, control, recipe.decimation, "mean", recipe.threads
    )
    try:
        kept = successful(replays, cell)
    except ReplayError:
        return NO_REPLAY
    episodes = [Episode(*one.episode, task.robot_observation_size) for one in kept]
    settings = dict(recipe.training)
    kind, fraction = POLICIES.find(settings.pop("policy")), settings.pop("validation_fraction")
    number = torch_seed(0, STAGE, cell.name, seed)
    policy, _ = kind.fit(
        *split(episodes, fraction, number), kind.settings(**settings), number, recipe.threads
    )
    rollouts = roll_out(
        task, policy.act, policy.history, recipe.executed, control,
        task.sample_starts(generator(0, STAGE), recipe.rollouts), recipe.decimation,
        recipe.threads,
    )  # fmt: skip
    return float(rollouts.table.success.mean())
