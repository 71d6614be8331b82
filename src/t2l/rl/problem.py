"""What is to be learned: under which condition, in which simulator, and with what a trial chose."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from t2l.environment.interface import action_space, scale_per_joint
from t2l.gains import Cell
from t2l.rl.settings import Search, Settings
from t2l.robots import Robot
from t2l.sim.training_simulator import Parameters
from t2l.tasks import Rewarded, make_task

if TYPE_CHECKING:
    from t2l.rl.environments import Environments


@dataclass(frozen=True)
class Choice:
    """What a trial chooses.

    Attributes:
        action_scale: α of each of the robot's groups of joints that share one, rad.
        reward_weights: of the task's reward, those that differ from its own.
    """

    action_scale: tuple[float, ...]
    reward_weights: Mapping[str, float] = field(default_factory=dict)


def scale_names(robot: Robot) -> list[str]:
    """What tables call the action scale of each group."""
    return [f"action_scale_{group}" for group in robot.scale_groups]


@dataclass(frozen=True)
class Condition:
    """An entry of `sim_to_real.conditions` in a configuration.

    Attributes:
        name: of its folder.
        task: name of a file in config/tasks/, of a task with a reward.
        parameters: content of that file.
        actions: what the policy's output means, see `t2l.actions`.
        policy_rate_hz: how often the policy acts, in simulation and on the robot.
        randomisation: by which fraction parameters differ from environment to environment while
            training.
        action_scales: those that are known, see `given`; with any, nothing is searched.
    """

    name: str
    task: str
    policy_rate_hz: float
    randomisation: float
    actions: Mapping[str, Any]
    parameters: Mapping[str, Any]
    action_scales: Sequence[Mapping[str, Any]] = ()

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any]) -> "Condition":
        """The condition of a checked configuration's entry, with its task's parameters."""
        return cls(**entry)

    @property
    def searched(self) -> bool:
        """Whether trials look for action scales."""
        return not self.action_scales

    def cells(self, cells: Iterable[Cell]) -> list[Cell]:
        """Those that it has of a study's cells."""
        given = {Cell(entry["kp"], entry["kd"]) for entry in self.action_scales}
        return [cell for cell in cells if self.searched or cell in given]

    def given(self, cell: Cell) -> Choice | None:
        """The action scales that are known for a cell."""
        for entry in self.action_scales:
            if Cell(entry["kp"], entry["kd"]) == cell:
                return Choice(tuple(map(float, entry["rad"])))
        return None

    def make_task(self) -> Rewarded:
        """The task.

        Raises:
            ConfigurationError: its robot is not known or not installed.
        """
        return make_task(self.parameters)


@dataclass(frozen=True, eq=False)
class Problem:
    """A condition in the identified simulator of a cell, whose parameters are (njoint,) each."""

    condition: Condition
    cell: Cell
    parameters: Parameters
    rate_hz: float
    horizon_s: float

    @cached_property
    def task(self) -> Rewarded:
        """The condition's, with the reward it comes with."""
        return self.condition.make_task()

    def environments(
        self,
        choice: Choice,
        settings: Settings,
        n: int,
        seed: int,
        training: bool = False,
        threads: int = 1,
        simulator: Any = None,
    ) -> "Environments":
        """`n` environments; only those for training are randomised, staggered and noisy.

        Args:
            simulator: see `Environment`.

        Raises:
            ConfigurationError: an action scale or the policy's rate is not allowed.
        """
        # it loads torch, which only training needs
        from t2l.rl.environments import Environments

        robot = self.task.robot
        actions = action_space(
            self.condition.actions, robot, scale_per_joint(choice.action_scale, robot)
        )
        return Environments(
            self.task.reweighted(choice.reward_weights), self.cell, self.parameters, actions,
            n, seed,
            randomisation=self.randomisation(training), threads=threads, simulator=simulator,
            **self.of_world(settings, training),
        )  # fmt: skip

    def randomisation(self, training: bool) -> float:
        """By which fraction parameters differ from robot to robot."""
        return self.condition.randomisation if training else 0.0

    def of_world(self, settings: Settings, training: bool) -> dict[str, Any]:
        """Arguments of `Environment` that do not depend on the cell."""
        noise = (settings.observation_noise_rad, settings.observation_noise_rad_s)
        return {
            "horizon_s": self.horizon_s,
            "policy_rate_hz": self.condition.policy_rate_hz,
            "rate_hz": self.rate_hz,
            "staggered": training,
            "clipped": settings.clip_actions,
            "noise": noise if training else (0.0, 0.0),
        }

    def study_name(self, search: Search, settings: Settings, seed: int) -> str:
        """Of Optuna's study: a change of what a trial is makes another; more trials do not."""
        content = {
            **asdict(self), "search": asdict(search) | {"trials": None},
            "settings": asdict(settings), "seed": seed,
        }  # fmt: skip
        text = json.dumps(content, sort_keys=True, default=np.ndarray.tolist)
        digest = hashlib.sha256(text.encode()).hexdigest()[:12]
        return f"{self.condition.name}/{self.cell.name}/{digest}"
