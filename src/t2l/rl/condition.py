"""Under which condition a policy is trained and deployed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from t2l.gains import Cell
from t2l.rl.choice import Choice
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
