"""A task of one's own with contacts: push a cube to a place on the table, with a closed hand."""

from typing import NamedTuple

import mujoco
import numpy as np

from t2l.robots import make_robot
from t2l.tasks import Rewarded
from t2l.tasks.poses import upright
from t2l.tasks.table_top import add_cube, pose_of, robot_starts, table_scene
from t2l.tasks.terms import (
    ObservationTerm,
    RewardTerm,
    TerminationTerm,
    action_change,
    minus,
    state_of,
)
from t2l.typed import Number, Typed


class PushParameters(Typed):
    """What a file in config/tasks/ may say."""

    robot: str = "fr3_hand"
    tolerance_m: Number = 0.03


class Measured(NamedTuple):
    """Made once a step, for all terms: (n, 3) m, and (n,) m."""

    cube: np.ndarray
    reach_m: np.ndarray
    goal_m: np.ndarray


class Push(Rewarded):
    """Success: the cube within `tolerance_m` of its goal at the end of an episode."""

    name, instruction, parameters = "push", "Push the cube to its place.", PushParameters
    hyperparameters, steady, least_rate_hz, goal_size = "lift", False, 200.0, 3
    rewards = (
        RewardTerm("reaching", 1.0, lambda at: 1 - np.tanh(at.now.reach_m / 0.1), "mine"),
        RewardTerm("goal", 16.0, lambda at: 1 - np.tanh(at.now.goal_m / 0.3), "IsaacLab's lift"),
        RewardTerm("change", 1e-4, minus(action_change), "IsaacLab's lift"),
    )
    terminations = (TerminationTerm("far", lambda at: np.abs(at.now.cube[:, 1]) > 0.5),)

    def __init__(self, robot, tolerance_m):
        self.robot, self.tolerance_m = make_robot(robot), tolerance_m
        self.observations = (
            *state_of(self.robot.joints),
            ObservationTerm(("cube.x", "cube.y", "cube.z"), lambda at: at.now.cube),
            ObservationTerm(("goal.x", "goal.y", "goal.z"), lambda at: at.goal),
        )
        self.robot_observation_size = 2 * len(self.robot.joints)

    def spec(self, visual):
        """A robot, a table, a cube."""
        spec = table_scene(self.robot, True, visual)
        add_cube(spec, "cube", 0.06, 0.1, (0.2, 0.4, 0.8, 1))
        return spec

    def sample_starts(self, rng, n):
        """The cube anywhere in front of the robot."""
        qpos = robot_starts(self, rng, n, 0.0)
        place = np.column_stack([rng.uniform([0.4, -0.2], [0.6, 0.2], (n, 2)), np.full(n, 0.03)])
        qpos[:, pose_of(self.model, "cube")] = upright(place, np.zeros(n))
        return qpos

    def sample_goals(self, rng, n):
        """On the table."""
        return np.column_stack([rng.uniform([0.4, -0.2], [0.6, 0.2], (n, 2)), np.full(n, 0.03)])

    def measure(self, batch, goal):
        """Distances, from the positions of cube and hand."""
        sites = batch.bind("site_xpos")
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        cube = batch.qpos[:, pose_of(self.model, "cube")][:, :3].copy()
        ends = sites[:, self.tool_sites[0]], goal
        return Measured(cube, *(np.linalg.norm(end - cube, axis=1) for end in ends))

    def success(self, at):
        """See above."""
        return at.now.goal_m < self.tolerance_m
