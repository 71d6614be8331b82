"""The same starts and goals on the robot and in its simulator."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from t2l.environment.interface import action_space
from t2l.gains import Cell
from t2l.hardware.guard import Workspace
from t2l.hardware.registry import open_backend
from t2l.policies import Policy
from t2l.rl.problem import Condition
from t2l.seeds import generator
from t2l.sim.training_simulator import Parameters
from t2l.transfer.deploy import Rollouts, deploy
from t2l.transfer.identified import IdentifiedRobot


@dataclass(frozen=True)
class Deployment:
    """How policies are deployed.

    Attributes:
        rollouts: on the robot, and as many in simulation.
        duration_s: of each.
        rate_hz: of the training simulator.
    """

    rollouts: int
    duration_s: float
    rate_hz: float
    workspace: Workspace

    @classmethod
    def from_section(
        cls, section: Mapping[str, Any], duration_s: float, rate_hz: float
    ) -> "Deployment":
        """What the `deployment` section of a checked configuration asks for."""
        lower, upper = (tuple(section[f"workspace_{side}_m"]) for side in ("lower", "upper"))
        return cls(section["rollouts"], duration_s, rate_hz, Workspace(lower, upper))


def matched_rollouts(
    robot: Mapping[str, Any],
    policy: Policy,
    condition: Condition,
    cell: Cell,
    parameters: Parameters,
    deployment: Deployment,
    seed: int,
    folder: Path,
) -> tuple[Rollouts, Rollouts]:
    """Rollouts on the robot, then in the simulator from where the robot began.

    Args:
        robot: the `robot` section of a checked configuration.
        parameters: of the identified simulator.
        seed: starts and goals are the same for every cell and condition of a task.
        folder: for rollouts of an arm that runs one after another; those that are there already,
            of the same policy, are not run again.

    Raises:
        BackendError: the robot cannot be reached, or does not go on.
    """
    task = condition.make_task()
    actions = action_space(condition.actions, task.robot, policy.action_scale)
    draw = generator(seed, "deployment", task.name)
    starts = task.sample_starts(draw, deployment.rollouts)
    goals = task.sample_goals(draw, deployment.rollouts)
    rest = (condition.policy_rate_hz, deployment.duration_s, deployment.workspace)
    with open_backend(robot, task.robot, deployment.rollouts) as arm:
        kept = folder / _digest(policy, starts, goals, robot, rest)
        real = deploy(arm, policy, task, actions, cell, starts, goals, *rest, folder=kept)
    begun = np.where(np.isfinite(real.q[0]), real.q[0], starts)
    simulator = IdentifiedRobot(task.robot, deployment.rollouts, parameters, deployment.rate_hz)
    return real, deploy(simulator, policy, task, actions, cell, begun, goals, *rest)


def _digest(policy: Policy, starts: np.ndarray, goals: np.ndarray, *more: object) -> str:
    digest = hashlib.sha256(repr((policy.metadata(), *more)).encode())
    for array in (*policy.tensors().values(), starts, goals):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:12]
