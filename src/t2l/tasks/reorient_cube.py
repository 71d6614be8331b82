"""Reorient-Cube: push and tip a cube on a table into a pose, with a closed hand.

The study has such a task in its table of existence (section V-B), and states neither rewards nor
numbers of it. Scene, terms, weights and tolerances here are t2l's, after IsaacLab's lift.
"""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.robots import make_robot
from t2l.tasks.poses import position_and_axes, tilted, upright
from t2l.tasks.table_top import (
    Range,
    add_cube,
    beyond_table,
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
OWN = "t2l, after IsaacLab's lift"
# over which distances, m and rad, the terms fall
REACH, FAR, TURN = 0.1, 0.2, 0.5


class ReorientCubeParameters(Typed):
    """Of a cube to push and tip."""

    robot: str = Field("fr3_hand", description="name of a robot of one arm with a gripper")
    gravity_compensation: Switch = Field(
        True, description="whether the robot cancels the gravity of its arm"
    )
    start_rad: list[Number] = Field(
        [], description="where the arm starts, rad a joint; without this key at the robot's home"
    )
    start_spread_rad: Number = Field(
        0.0, ge=0, le=0.3, description="standard deviation of the arm's start about that, rad"
    )
    cube_size_m: Number = Field(0.06, ge=0.01, le=0.2, description="edge of the cube, m")
    cube_mass_kg: Number = Field(0.1, gt=0, le=2, description="mass of the cube, kg")
    workspace_x_m: Range = Field([0.4, 0.6], description="of starts and goals, [low, high], m")
    workspace_y_m: Range = Field([-0.2, 0.2], description="of starts and goals, [low, high], m")
    cube_yaw_rad: Number = Field(
        0.785, ge=0, le=3.15, description="starts and goals are turned up to it either way, rad"
    )
    tipped_share: Number = Field(
        0.25, ge=0, le=1, description="share of goals for which the cube must be tipped on a side"
    )
    tolerance_m: Number = Field(
        0.03, gt=0, le=0.5, description="success is a distance of the cube's centre below it, m"
    )
    tolerance_rad: Number = Field(
        0.2, gt=0, le=3.15, description="and an angle from the goal below it, rad"
    )


class Measured(NamedTuple):
    """What terms need of a scene, (n, …) each.

    Attributes:
        cube: (n, 7) pose, position in m above a quaternion.
        reach_m, goal_m: (n,) from the grip to the cube, and from the cube to the goal.
        turn_rad: (n,) the angle from the cube's orientation to the goal's.
    """

    cube: np.ndarray
    reach_m: np.ndarray
    goal_m: np.ndarray
    turn_rad: np.ndarray


def there(at: Moment) -> np.ndarray:
    """Whether position and orientation are within their tolerances, softly."""
    near = 1 - np.tanh(at.now.goal_m / at.task.tolerance_m)
    return near * (1 - np.tanh(at.now.turn_rad / at.task.tolerance_rad))


class ReorientCube(Rewarded):
    """Success: the cube within both tolerances of its goal at the end of an episode.

    Raises:
        ConfigurationError: no such robot.
        ValueError: it has not one arm with a gripper, or a range is empty.
    """

    name = "reorient_cube"
    instruction = "Push and tip the cube into its pose, with a closed hand."
    parameters = ReorientCubeParameters
    hyperparameters = "lift"
    steady = False
    closed_hand = True
    # as of Lift-Cube: the same fingers
    least_rate_hz = 200.0
    goal_size = 7
    rewards = (
        RewardTerm("reaching", 1.0, lambda at: 1 - np.tanh(at.now.reach_m / REACH), OWN),
        RewardTerm("goal", 8.0, lambda at: 1 - np.tanh(at.now.goal_m / FAR), OWN),
        RewardTerm("turn", 8.0, lambda at: 1 - np.tanh(at.now.turn_rad / TURN), OWN),
        RewardTerm("there", 10.0, there, OWN),
        RewardTerm("change", 1e-4, minus(action_change), OWN),
        RewardTerm("velocity", 1e-4, minus(speed), OWN),
    )
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
        tipped_share: float,
        tolerance_m: float,
        tolerance_rad: float,
    ):
        self.robot, self.gravity_compensation = make_robot(robot), gravity_compensation
        check_hands(self.robot, 1)
        check_range("workspace_x_m", *workspace_x_m)
        check_range("workspace_y_m", *workspace_y_m)
        self.start, self.start_spread_rad = start_at(self.robot, start_rad), start_spread_rad
        self.cube_size_m, self.cube_mass_kg = cube_size_m, cube_mass_kg
        self.workspace = np.array([workspace_x_m, workspace_y_m])
        self.cube_yaw_rad, self.tipped_share = cube_yaw_rad, tipped_share
        self.tolerance_m, self.tolerance_rad = tolerance_m, tolerance_rad
        pose = (*"xyz", *(f"axis{i}_{c}" for i in (1, 2) for c in "xyz"))
        self.observations = (
            *state_of(self.robot.joints),
            ObservationTerm(
                tuple(f"{CUBE}.{name}" for name in pose), lambda at: position_and_axes(at.now.cube)
            ),
            ObservationTerm(
                tuple(f"goal.{name}" for name in pose), lambda at: position_and_axes(at.goal)
            ),
        )
        self.robot_observation_size = 2 * len(self.robot.joints)

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        spec = table_scene(self.robot, self.gravity_compensation, visual)
        add_cube(spec, CUBE, self.cube_size_m, self.cube_mass_kg, (0.16, 0.36, 0.75, 1))
        return spec

    def _places(self, rng, n) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) m on the table, and turns (n,) rad."""
        height = np.full((n, 1), self.cube_size_m / 2)
        place = np.concatenate([rng.uniform(*self.workspace.T, (n, 2)), height], axis=1)
        return place, rng.uniform(-self.cube_yaw_rad, self.cube_yaw_rad, n)

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`."""
        qpos = robot_starts(self, rng, n, self.start_spread_rad, self.start)
        qpos[:, pose_of(self.model, CUBE)] = upright(*self._places(rng, n))
        return qpos

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: poses, position in m and quaternion."""
        tipped = rng.random(n) < self.tipped_share
        quarter = np.where(rng.random(n) < 0.5, 1, -1) * np.pi / 2
        return tilted(*self._places(rng, n), np.where(tipped, quarter, 0.0))

    def measure(self, batch: Batch, goal):
        """See `Rewarded.measure`."""
        sites = batch.bind("site_xpos")
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        cube = batch.qpos[:, pose_of(self.model, CUBE)].copy()
        cosine = np.abs((cube[:, 3:] * goal[:, 3:]).sum(axis=1))
        return Measured(
            cube=cube,
            reach_m=np.linalg.norm(sites[:, self.tool_sites[0]] - cube[:, :3], axis=1),
            goal_m=np.linalg.norm(goal[:, :3] - cube[:, :3], axis=1),
            turn_rad=2 * np.arccos(np.minimum(cosine, 1.0)),
        )

    def success(self, at):
        """See `Rewarded.success`."""
        near = at.now.goal_m < self.tolerance_m
        return near & (at.now.turn_rad < self.tolerance_rad)
