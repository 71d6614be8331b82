"""What is to be learned."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from t2l.environment.interface import action_space, scale_per_joint
from t2l.gains import Cell
from t2l.rl.choice import Choice
from t2l.rl.condition import Condition
from t2l.rl.settings import Search, Settings
from t2l.sim.training_simulator import Parameters
from t2l.tasks import Rewarded

if TYPE_CHECKING:
    from t2l.rl.environments import Environments


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
    ) -> "Environments":
        """`n` environments; only those for training are randomised, staggered and noisy.

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
            randomisation=self.randomisation(training), threads=threads,
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
