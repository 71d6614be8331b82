"""Under which condition a policy is trained and deployed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Condition:
    """An entry of `sim_to_real.conditions` in a configuration.

    Attributes:
        name: of its folder.
        task: a name in `t2l.tasks.reach.TASKS`.
        policy_rate_hz: how often the policy acts, in simulation and on the robot.
        randomisation: by which fraction parameters differ from environment to environment while
            training.
    """

    name: str
    task: str
    policy_rate_hz: float
    randomisation: float

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any]) -> "Condition":
        """The condition of a checked configuration's entry."""
        return cls(**entry)
