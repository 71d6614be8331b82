"""Lift-Cube: grasp a cube, lift it, and hold it where the goal is; by reinforcement learning.

Scene, goals, terms and weights are those of IsaacLab's manager-based lift environment (Franka,
joint positions), from which the study's task is derived (App. E). The success rule is the study's.
"""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import make_robot
from t2l.tasks.poses import upright
from t2l.tasks.table_top import (
    Range,
    add_cube,
    beyond_table,
    check_graspable,
    check_hands,
    check_range,
    pose_of,
    robot_starts,
    start_at,
    table_scene,
)
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import (
    Moment,
    ObservationTerm,
    RewardTerm,
    TerminationTerm,
    action_change,
    minus,
    speed,
    state_of,
)
from t2l.typed import Number, Switch, Typed

CUBE = "cube"
TEMPLATE = "IsaacLab, manager-based lift environment"
# of the template: heights and distances, m
LIFTED, REACH, FAR, NEAR = 0.04, 0.1, 0.3, 0.05
# the template's curriculum: after 10 000 steps of its 4096 robots what costs weighs 1000 times more
CURRICULUM = (10_000 * 4096, 1000.0)


class LiftCubeParameters(Typed):
    """Of a cube to lift."""

    robot: str = Field("fr3_hand", description="name of a robot of one arm with a gripper")
    gravity_compensation: Switch = Field(
        True, description="whether the robot cancels the gravity of its arm, as in IsaacLab"
    )
    start_rad: list[Number] = Field(
        [], description="where the arm starts, rad a joint; without this key at the robot's home"
    )
    start_spread_rad: Number = Field(
        0.0, ge=0, le=0.3, description="standard deviation of the arm's start about that, rad"
    )
    cube_size_m: Number = Field(0.048, ge=0.01, le=0.2, description="edge of the cube, m")
    cube_mass_kg: Number = Field(0.1, gt=0, le=2, description="mass of the cube, kg")
    workspace_x_m: Range = Field([0.4, 0.6], description="where the cube starts, [low, high], m")
    workspace_y_m: Range = Field([-0.25, 0.25], description="where the cube starts, [low, high], m")
    cube_yaw_rad: Number = Field(
        0.0, ge=0, le=0.7854, description="the cube starts turned up to it, rad"
    )
    goal_x_m: Range = Field([0.4, 0.6], description="where goals are, [low, high], m")
    goal_y_m: Range = Field([-0.25, 0.25], description="where goals are, [low, high], m")
    goal_z_m: Range = Field([0.25, 0.5], description="where goals are, [low, high], m")
    tolerance_m: Number = Field(
        0.05, gt=0, le=0.5, description="success is a distance of the cube's centre below it, m"
    )


class Measured(NamedTuple):
    """What terms need of a scene, (n, …) each.

    Attributes:
        cube, grip: (n, 3) centre of the cube, and the point between the fingertips, m.
        opening: (n, 1) how far a finger is open, in the gripper's unit.
        reach_m, goal_m: (n,) from the grip to the cube, and from the cube to the goal.
    """

    cube: np.ndarray
    grip: np.ndarray
    opening: np.ndarray
    reach_m: np.ndarray
    goal_m: np.ndarray


def lifted(at: Moment) -> np.ndarray:
    """Whether the cube's centre is so high that it is off the table, 0 or 1."""
    return (at.now.cube[:, 2] > LIFTED).astype(float)


class LiftCube(Rewarded):
    """Success: the cube's centre within `tolerance_m` of its goal at the end of an episode.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it has not one arm with a gripper that opens wide enough, or a range is empty.
    """

    name = "lift_cube"
    instruction = "Lift the cube to its goal and hold it there."
    parameters = LiftCubeParameters
    hyperparameters = "lift"
    steady = False
    # at 100 Hz the force-limited fingers swing about what they are to press
    least_rate_hz = 200.0
    goal_size = 3
    rewards = (
        RewardTerm("reaching", 1.0, lambda at: 1 - np.tanh(at.now.reach_m / REACH), TEMPLATE),
        RewardTerm("lifting", 15.0, lifted, TEMPLATE),
        RewardTerm(
            "goal", 16.0, lambda at: lifted(at) * (1 - np.tanh(at.now.goal_m / FAR)), TEMPLATE
        ),
        RewardTerm(
            "goal_fine", 5.0, lambda at: lifted(at) * (1 - np.tanh(at.now.goal_m / NEAR)), TEMPLATE
        ),
        RewardTerm("change", 1e-4, minus(action_change), TEMPLATE, CURRICULUM),
        RewardTerm("velocity", 1e-4, minus(speed), TEMPLATE, CURRICULUM),
    )
    # the template waits until it has fallen
    terminations = (TerminationTerm("off_table", lambda at: beyond_table(at.now.cube)),)

    def __init__(
        self,
        robot: str,
        gravity_compensation: bool,
        start_rad: Sequence[float],
        start_spread_rad: float,
        cube_size_m: float,
        cube_mass_kg: float,
        workspace_x_m: tuple[float, float],
        workspace_y_m: tuple[float, float],
        cube_yaw_rad: float,
        goal_x_m: tuple[float, float],
        goal_y_m: tuple[float, float],
        goal_z_m: tuple[float, float],
        tolerance_m: float,
    ):
        self.robot, self.gravity_compensation = make_robot(robot), gravity_compensation
        check_hands(self.robot, 1)
        check_graspable("cube_size_m", cube_size_m, self.robot)
        self.start, self.start_spread_rad = start_at(self.robot, start_rad), start_spread_rad
        self.tolerance_m = tolerance_m
        self.cube_size_m, self.cube_mass_kg = cube_size_m, cube_mass_kg
        self.cube_yaw_rad = cube_yaw_rad
        self.workspace = np.array([workspace_x_m, workspace_y_m])
        self.goals = np.array([goal_x_m, goal_y_m, goal_z_m])
        for key, (low, high) in {
            "workspace_x_m": workspace_x_m, "workspace_y_m": workspace_y_m,
            "goal_x_m": goal_x_m, "goal_y_m": goal_y_m, "goal_z_m": goal_z_m,
        }.items():  # fmt: skip
            check_range(key, low, high)
        self.observations = (
            *state_of(self.robot.joints),
            ObservationTerm(("finger",), lambda at: at.now.opening),
            ObservationTerm(tuple(f"{CUBE}.{c}" for c in "xyz"), lambda at: at.now.cube),
            ObservationTerm(tuple(f"goal.{c}" for c in "xyz"), lambda at: at.goal),
        )
        self.robot_observation_size = 2 * len(self.robot.joints) + 1

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        spec = table_scene(self.robot, self.gravity_compensation, visual)
        add_cube(spec, CUBE, self.cube_size_m, self.cube_mass_kg, (0.80, 0.20, 0.16, 1))
        return spec

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`."""
        qpos = robot_starts(self, rng, n, self.start_spread_rad, self.start)
        place = rng.uniform(*self.workspace.T, (n, 2))
        yaw = rng.uniform(-self.cube_yaw_rad, self.cube_yaw_rad, n)
        height = np.full((n, 1), self.cube_size_m / 2)
        qpos[:, pose_of(self.model, CUBE)] = upright(np.concatenate([place, height], axis=1), yaw)
        return qpos

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: of the cube's centre, m."""
        return rng.uniform(*self.goals.T, (n, 3))

    def measure(self, batch: Batch, goal):
        """See `Rewarded.measure`."""
        sites = batch.bind("site_xpos")
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        grip, qpos = sites[:, self.tool_sites[0]].copy(), batch.qpos
        cube = qpos[:, pose_of(self.model, CUBE)][:, :3].copy()
        away, to_go = (np.linalg.norm(end - cube, axis=1) for end in (grip, goal))
        return Measured(cube, grip, qpos[:, self.opening_qpos], away, to_go)

    def success(self, at):
        """See `Rewarded.success`."""
        return at.now.goal_m < self.tolerance_m
