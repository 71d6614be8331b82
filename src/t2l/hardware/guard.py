"""Commands are checked before they are sent."""

from dataclasses import dataclass

import numpy as np

from t2l.gains import Cell
from t2l.robots import Robot
from t2l.robots.kinematics import ToolKinematics
from t2l.sim.controllers.joint_pd import pd_torque


@dataclass(frozen=True)
class Workspace:
    """A box that the flange must stay in, in the frame of the robot's base, m."""

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]


class Guard:
    """Says what is wrong with commands that are held for `period_s`, for `n` robots."""

    def __init__(self, robot: Robot, n: int, cell: Cell, period_s: float, workspace: Workspace):
        self._robot, self._cell, self._workspace = robot, cell, workspace
        self._farthest = robot.velocity_limit * period_s
        self._tool = ToolKinematics(robot, n)

    def objections(self, q_des: np.ndarray, q: np.ndarray, dq: np.ndarray) -> list[str]:
        """For each robot why q_des (n, njoint) must not be sent in state q, dq, or nothing.

        Commands and joints must lie within the joints' ranges, ask for no more than the torque
        limits, find joints no faster than they may be, and the flange must stay in the workspace,
        now and where the command can lead until the next, at the joints' greatest speed. (Soft
        gains take commands to where the arm never comes.)
        """
        torque = pd_torque(q_des, q, dq, self._cell.kp, self._cell.kd)
        joints = self._robot.joints
        low, high = self._robot.position_limit.T
        speed, most = self._robot.velocity_limit, self._robot.torque_limit
        checks = [
            _beyond("position command of", q_des, low, high, "rad", joints),
            _beyond("position of", q, low, high, "rad", joints),
            _beyond("velocity of", dq, -speed, speed, "rad/s", joints),
            _beyond("torque of", torque, -most, most, "N·m", joints),
        ]
        ahead = q + np.clip(q_des - q, -self._farthest, self._farthest)
        for where, at in (("measured", q), ("commanded", ahead)):
            position = self._tool.pose(at)[:, :3]
            box = (np.array(self._workspace.lower), np.array(self._workspace.upper))
            axes = [f"{axis} of the flange" for axis in "xyz"]
            checks.append(_beyond(where, position, *box, "m", axes))
        return [next((text for text in texts if text), "") for texts in zip(*checks, strict=True)]


def _beyond(
    what: str, values: np.ndarray, low: np.ndarray, high: np.ndarray, unit: str, names
) -> list[str]:
    # what is not a number is not within anything
    outside = ~((values >= low) & (values <= high))
    texts = []
    for row, out in zip(values, outside, strict=True):
        if not out.any():
            texts.append("")
            continue
        i = int(np.argmax(out))
        texts.append(
            f"{what} {names[i]} {row[i]:.4g} {unit}; allowed: {low[i]:.4g} to {high[i]:.4g}"
        )
    return texts
