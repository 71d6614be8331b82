"""Under which condition a policy is trained and deployed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from t2l.tasks import Rewarded, make_task


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
    """

    name: str
    task: str
    policy_rate_hz: float
    randomisation: float
    actions: Mapping[str, Any]
    parameters: Mapping[str, Any]

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any]) -> "Condition":
        """The condition of a checked configuration's entry, with its task's parameters."""
        return cls(**entry)

    def make_task(self) -> Rewarded:
        """The task.

        Raises:
            ConfigurationError: its robot is not known or not installed.
        """
        return make_task(self.parameters)
