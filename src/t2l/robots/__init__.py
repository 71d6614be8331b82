"""Robots: their models, joints, limits and tools, by name or from a file of the user's."""

from t2l.robots.registry import ROBOTS, make_robot
from t2l.robots.robot import Gripper, JointGroup, Robot, Walker

__all__ = ["ROBOTS", "Gripper", "JointGroup", "Robot", "Walker", "make_robot"]
