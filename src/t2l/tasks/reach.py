"""Reaching a goal and holding it: joint positions, or the pose of the tool."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Literal

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import make_robot
from t2l.robots.kinematics import ToolKinematics, site_pose
from t2l.sim.arrays import columns
from t2l.tasks.bare_robot import bare_scene
from t2l.tasks.reach_rewards import JOINT_REWARDS, PROGRESS, TOOL_REWARDS, sizes
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import ObservationTerm, RewardTerm, norm, state_of
from t2l.typed import Number, Switch, Typed

MARGIN_RAD = 0.1  # of goals from the ends of the ranges

Tolerance = Annotated[Number, Field(gt=0, le=1)]


class ReachParameters(Typed):
    """What every reaching task takes."""

    robot: str = Field("fr3", description="name of the robot, which is bare")
    start_spread_rad: Number = Field(
        0.1, ge=0, le=0.5, description="standard deviation of starts about the robot's home, rad"
    )
    goal_spread_rad: Number = Field(
        0.4, gt=0, le=2, description="goals lie this far from home at most, at every joint, rad"
    )
    reward: Literal["progress", "isaaclab"] = Field(
        PROGRESS,
        description="`progress`: pays for coming closer at once; `isaaclab`: the terms and weights "
        "of IsaacLab's template, as in the study",
    )
    steady: Switch = Field(
        True,
        description="whether a success must rest at the end, without jitter; the study's need not",
    )


class Reach(Rewarded):
    """A goal to reach and hold; success is judged at the end of an episode.

    Args:
        robot: name of a robot.
        start_spread_rad: standard deviation of starts about the robot's home.
        goal_spread_rad: half the width of the range of goals about it.
        reward: what it pays, see `t2l.tasks.reach_rewards`.
        steady: see `Rewarded`.
    """

    rewards_of: Mapping[str, tuple[RewardTerm, ...]]

    def __init__(
        self,
        robot: str,
        start_spread_rad: float,
        goal_spread_rad: float,
        reward: str = PROGRESS,
        steady: bool = True,
    ):
        self.robot, self.steady = make_robot(robot), steady
        self.rewards = self.rewards_of[reward]
        self.start_spread_rad, self.goal_spread_rad = start_spread_rad, goal_spread_rad
        joints = self.robot.joints
        self.robot_observation_size = 2 * len(joints)
        errors = tuple(f"error.{name}" for name in self.error_names)
        self.observations = (*state_of(joints), ObservationTerm(errors, lambda at: at.now))

    @property
    def error_names(self) -> tuple[str, ...]:
        """Of what is left to do, which `measure` gives."""
        raise NotImplementedError

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        return bare_scene(self.robot, visual)

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`."""
        home = self.robot.home
        return home + rng.normal(0.0, self.start_spread_rad, (n, home.size))

    def sample_joint_goals(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n, njoint) rad, within the ranges, each joint uniform about home."""
        home = self.robot.home
        inner = (self.robot.position_limit + np.array([MARGIN_RAD, -MARGIN_RAD])).T
        low, high = (np.clip(home + s * self.goal_spread_rad, *inner) for s in (-1, 1))
        return rng.uniform(low, high, (n, home.size))


class JointReachParameters(ReachParameters):
    """Of a goal for the joints."""

    tolerance_rad: Tolerance = Field(
        0.1, description="success is a distance from the goal below it, over all joints, rad"
    )


class JointReach(Reach):
    """Success: ‖q − q_goal‖ below `tolerance_rad`; the study's is 0.1 rad."""

    name = "joint_reach"
    instruction = "Move every joint to its goal and hold it there."
    parameters = JointReachParameters
    rewards_of = JOINT_REWARDS
    on_gpu = True

    def __init__(self, tolerance_rad: float, **of_reach):
        super().__init__(**of_reach)
        self.tolerance_rad = tolerance_rad
        self.goal_size = len(self.robot.joints)

    @property
    def error_names(self):
        """See `Reach.error_names`."""
        return self.robot.joints

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`."""
        return self.sample_joint_goals(rng, n)

    def measure(self, batch: Batch, goal):
        """See `Rewarded.measure`: what is left of the way, (n, njoint) rad."""
        return goal - batch.qpos[:, self._arm]

    @cached_property
    def _arm(self) -> np.ndarray | slice:
        return columns(self.arm_qpos)

    def success(self, at):
        """See `Rewarded.success`."""
        return norm(at.now) < self.tolerance_rad


class EndEffectorReachParameters(ReachParameters):
    """Of a goal for the tool."""

    position_tolerance_m: Tolerance = Field(
        0.02, description="success is a distance from the goal below it, m"
    )
    orientation_tolerance_rad: Tolerance = Field(
        0.1, description="and an angle from the goal below it, rad"
    )


class EndEffectorReach(Reach):
    """Success: the tool within both tolerances of its goal; the study's are 0.02 m and 0.1 rad."""

    name = "end_effector_reach"
    instruction = "Move the tool to its goal and hold it there."
    parameters = EndEffectorReachParameters
    goal_size = 12
    error_names = ("x", "y", "z", "rx", "ry", "rz")
    rewards_of = TOOL_REWARDS
    # the study tunes the weights of this task's reward, and of no other reaching task
    tuned = tuple(dict.fromkeys(term.name for terms in rewards_of.values() for term in terms))

    def __init__(self, position_tolerance_m: float, orientation_tolerance_rad: float, **of_reach):
        super().__init__(**of_reach)
        self.tuned = tuple(self.weights)
        self.position_tolerance_m = position_tolerance_m
        self.orientation_tolerance_rad = orientation_tolerance_rad

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: poses of sampled joint positions, so all can be reached."""
        return ToolKinematics(self.robot, n).pose(self.sample_joint_goals(rng, n))

    def measure(self, batch: Batch, goal):
        """See `Rewarded.measure`: what is left, (n, 6), in m and as a rotation vector in rad."""
        position, rotation = batch.bind("site_xpos"), batch.bind("site_xmat")
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        pose = site_pose(position, rotation, int(self.tool_sites[0]))
        here, there = pose[:, 3:].reshape(-1, 3, 3), goal[:, 3:].reshape(-1, 3, 3)
        return np.concatenate(
            [goal[:, :3] - pose[:, :3], _rotation_vector(there @ here.transpose(0, 2, 1))], axis=1
        )

    def success(self, at):
        """See `Rewarded.success`."""
        away, turned = sizes(at.now)
        return (away < self.position_tolerance_m) & (turned < self.orientation_tolerance_rad)


def _rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Axis times angle (n, 3) rad of rotation matrices (n, 3, 3)."""
    # SciPy's rotations take long to import
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()
