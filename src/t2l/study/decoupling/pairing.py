"""A controller's gains, and the behaviour that a policy on top of them is trained for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from t2l.environment.ideal import ideal_plant
from t2l.gains import Cell
from t2l.rl.problem import Choice, Condition, Problem
from t2l.tasks import Rewarded, make_task

POLICY_RATE_HZ = 50.0
PHYSICS_RATE_HZ = 100.0  # of the study's simulator


@dataclass(frozen=True, eq=False)
class Pairing:
    """Gains and a reward, see `t2l.tasks.pose_hold.PoseHold`.

    Attributes:
        name: of its folder.
        kp, kd: gains, N·m/rad and N·m·s/rad.
        actions: what the policy's output means, see `t2l.actions`.
        lambda_rad2: λ.
        change: α.
        tolerance_rad: within which the pose is held; None for the task's own.
    """

    name: str
    kp: float
    kd: float
    actions: Mapping[str, Any]
    lambda_rad2: float
    change: float
    tolerance_rad: float | None = None

    @property
    def cell(self) -> Cell:
        """The gains."""
        return Cell(self.kp, self.kd)

    def choice(self, task: Rewarded, torque_share: float) -> Choice:
        """Action scales with which a full action asks every joint for a share of its torque limit.

        The scale of a group of joints is that of its weakest joint.
        """
        robot = task.robot
        scale = torque_share * robot.torque_limit / self.kp
        groups = range(len(robot.scale_groups))
        weakest = tuple(float(scale[robot.scale_group == group].min()) for group in groups)
        return Choice(weakest, {"lambda_rad2": self.lambda_rad2, "change": self.change})

    def problem(
        self, name: str, parameters: Mapping[str, Any], horizon_s: float, **actions: Any
    ) -> Problem:
        """The task of that name and file in a simulator with the pairing's gains.

        Args:
            actions: what they mean, in place of the pairing's.
        """
        if self.tolerance_rad is not None:
            parameters = {**parameters, "tolerance_rad": self.tolerance_rad}
        condition = Condition(
            name=self.name, task=name, policy_rate_hz=POLICY_RATE_HZ, randomisation=0.0,
            actions=actions or self.actions, parameters=parameters,
        )  # fmt: skip
        plant = ideal_plant(make_task(parameters), self.cell)
        return Problem(condition, self.cell, plant, PHYSICS_RATE_HZ, horizon_s)
