"""Reorient-Cube: push and tip a cube on a table into a pose, with a closed hand.

The study has such a task in its table of existence (section V-B), and states neither rewards nor
numbers of it. Scene, terms, weights and tolerances here are t2l's, after IsaacLab's lift.
"""

from typing import NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.sim.arrays import Array, namespace
from t2l.tasks.learned_table_top import CUBE, LearnedCube, LearnedCubeParameters
from t2l.tasks.poses import position_and_axes, tilted
from t2l.tasks.table_top import Range
from t2l.tasks.terms import (
    Moment,
    ObservationTerm,
    RewardTerm,
    action_change,
    minus,
    nearness,
    norm,
    speed,
)
from t2l.typed import Number

OWN = "t2l, after IsaacLab's lift"
# over which distances, m and rad, the terms fall
REACH, FAR, TURN = 0.1, 0.2, 0.5


class ReorientCubeParameters(LearnedCubeParameters):
    """Of a cube to push and tip."""

    cube_size_m: Number = Field(0.06, ge=0.01, le=0.2, description="edge of the cube, m")
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

    cube: Array
    reach_m: Array
    goal_m: Array
    turn_rad: Array


def there(at: Moment) -> Array:
    """Whether position and orientation are within their tolerances, softly."""
    near = nearness(at.now.goal_m, at.task.tolerance_m)
    return near * nearness(at.now.turn_rad, at.task.tolerance_rad)


class ReorientCube(LearnedCube):
    """Success: the cube within both tolerances of its goal at the end of an episode.

    Raises:
        ConfigurationError: no such robot.
        ValueError: as `LearnedCube`.
    """

    name = "reorient_cube"
    instruction = "Push and tip the cube into its pose, with a closed hand."
    parameters = ReorientCubeParameters
    hyperparameters = "lift"
    colour = (0.16, 0.36, 0.75, 1)
    closed_hand = True
    goal_size = 7
    rewards = (
        RewardTerm("reaching", 1.0, lambda at: nearness(at.now.reach_m, REACH), OWN),
        RewardTerm("goal", 8.0, lambda at: nearness(at.now.goal_m, FAR), OWN),
        RewardTerm("turn", 8.0, lambda at: nearness(at.now.turn_rad, TURN), OWN),
        RewardTerm("there", 10.0, there, OWN),
        RewardTerm("change", 1e-4, minus(action_change), OWN),
        RewardTerm("velocity", 1e-4, minus(speed), OWN),
    )

    def __init__(self, tipped_share: float, tolerance_m: float, tolerance_rad: float, **of_cube):
        super().__init__(**of_cube)
        self.tipped_share = tipped_share
        self.tolerance_m, self.tolerance_rad = tolerance_m, tolerance_rad
        pose = (*"xyz", *(f"axis{i}_{c}" for i in (1, 2) for c in "xyz"))
        self.observations = (
            *self.own_state,
            ObservationTerm(
                tuple(f"{CUBE}.{name}" for name in pose), lambda at: position_and_axes(at.now.cube)
            ),
            ObservationTerm(
                tuple(f"goal.{name}" for name in pose), lambda at: position_and_axes(at.goal)
            ),
        )

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: poses, position in m and quaternion."""
        tipped = rng.random(n) < self.tipped_share
        quarter = np.where(rng.random(n) < 0.5, 1, -1) * np.pi / 2
        return tilted(*self.sample_places(rng, n), np.where(tipped, quarter, 0.0))

    def measure(self, batch, goal):
        """See `Rewarded.measure`."""
        grip = self.grip(batch)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        xp = namespace(batch.qpos)
        cube = xp.asarray(batch.qpos[:, self.cube_qpos], copy=True)
        cosine = xp.abs((cube[:, 3:] * goal[:, 3:]).sum(axis=1))
        return Measured(
            cube=cube,
            reach_m=norm(grip - cube[:, :3]),
            goal_m=norm(goal[:, :3] - cube[:, :3]),
            turn_rad=2 * xp.acos(xp.clip(cosine, None, 1.0)),
        )

    def success(self, at):
        """See `Rewarded.success`."""
        near = at.now.goal_m < self.tolerance_m
        return near & (at.now.turn_rad < self.tolerance_rad)
