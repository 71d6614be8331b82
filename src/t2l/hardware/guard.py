"""Commands of policies are checked before they are sent."""

from dataclasses import dataclass

import numpy as np

from t2l.hardware.limits import Bounds, first_of, position_bounds, state_objections
from t2l.robots import Robot
from t2l.robots.kinematics import ToolKinematics


@dataclass(frozen=True)
class Workspace:
    """A box that the flange must stay in, in the frame of the robot's base, m."""

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]


class Guard:
    """Says what is wrong with commands that are held for `period_s`, for `n` robots.

    Torque and its rate are no reason to stop: the controller of the robot clamps both, every
    millisecond, as the study's does (App. G, "Real-World Deployment").
    """

    def __init__(self, robot: Robot, n: int, period_s: float, workspace: Workspace):
        self._robot, self._commands = robot, position_bounds(robot)
        axes = [f"{axis} of the flange" for axis in "xyz"]
        self._box = Bounds(axes, np.array(workspace.lower), np.array(workspace.upper), "m")
        self._farthest = robot.velocity_limit * period_s
        self._tool = ToolKinematics(robot, n)

    def objections(self, q_des: np.ndarray, q: np.ndarray, dq: np.ndarray) -> list[str]:
        """For each robot why q_des (n, njoint) must not be sent in state q, dq, or nothing.

        Commands and joints must lie within the joints' ranges and find joints no faster than they
        may be, and the flange must stay in the workspace, now and where the command can lead until
        the next, at the joints' greatest speed. (Soft gains take commands to where the arm never
        comes.)
        """
        ahead = q + np.clip(q_des - q, -self._farthest, self._farthest)
        return first_of(
            self._commands.objections("position command of", q_des),
            state_objections(self._robot, q, dq),
            self._box.objections("measured", self._tool.pose(q)[:, :3]),
            self._box.objections("commanded", self._tool.pose(ahead)[:, :3]),
        )
