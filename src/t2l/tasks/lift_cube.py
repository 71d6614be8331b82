"""Lift-Cube: grasp a cube, lift it, and hold it where the goal is; by reinforcement learning.

Scene, goals, terms and weights are those of IsaacLab's manager-based lift environment (Franka,
joint positions), from which the study's task is derived (App. E). The success rule is the study's.
"""

from typing import NamedTuple

import mujoco
import numpy as np
from pydantic import Field

from t2l.sim.arrays import Array, namespace
from t2l.tasks.learned_table_top import CUBE, LearnedCube, LearnedCubeParameters
from t2l.tasks.table_top import Range, check_graspable, check_range
from t2l.tasks.terms import (
    Moment,
    ObservationTerm,
    RewardTerm,
    action_change,
    indicator,
    minus,
    nearness,
    norm,
    speed,
)
from t2l.typed import Number

TEMPLATE = "IsaacLab, manager-based lift environment"
# of the template: heights and distances, m
LIFTED, REACH, FAR, NEAR = 0.04, 0.1, 0.3, 0.05
# the template's curriculum: after 10 000 steps of its 4096 robots what costs weighs 1000 times more
CURRICULUM = (10_000 * 4096, 1000.0)


class LiftCubeParameters(LearnedCubeParameters):
    """Of a cube to lift."""

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
        reach_m, goal_m: (n,) from the grip to the cube, and from the cube to the goal.
    """

    cube: Array
    grip: Array
    reach_m: Array
    goal_m: Array


def lifted(at: Moment) -> Array:
    """Whether the cube's centre is so high that it is off the table, 0 or 1."""
    return indicator(at.now.cube[:, 2] > LIFTED)


class LiftCube(LearnedCube):
    """Success: the cube's centre within `tolerance_m` of its goal at the end of an episode.

    Raises:
        ConfigurationError: no such robot.
        ValueError: as `LearnedCube`; or its gripper does not open wide enough.
    """

    name = "lift_cube"
    instruction = "Lift the cube to its goal and hold it there."
    parameters = LiftCubeParameters
    hyperparameters = "lift"
    colour = (0.80, 0.20, 0.16, 1)
    goal_size = 3
    rewards = (
        RewardTerm("reaching", 1.0, lambda at: nearness(at.now.reach_m, REACH), TEMPLATE),
        RewardTerm("lifting", 15.0, lifted, TEMPLATE),
        RewardTerm("goal", 16.0, lambda at: lifted(at) * nearness(at.now.goal_m, FAR), TEMPLATE),
        RewardTerm(
            "goal_fine", 5.0, lambda at: lifted(at) * nearness(at.now.goal_m, NEAR), TEMPLATE
        ),
        RewardTerm("change", 1e-4, minus(action_change), TEMPLATE, CURRICULUM),
        RewardTerm("velocity", 1e-4, minus(speed), TEMPLATE, CURRICULUM),
    )

    def __init__(
        self,
        goal_x_m: tuple[float, float],
        goal_y_m: tuple[float, float],
        goal_z_m: tuple[float, float],
        tolerance_m: float,
        **of_cube,
    ):
        super().__init__(**of_cube)
        check_graspable("cube_size_m", self.cube_size_m, self.robot)
        goals = {"goal_x_m": goal_x_m, "goal_y_m": goal_y_m, "goal_z_m": goal_z_m}
        for key, (low, high) in goals.items():
            check_range(key, low, high)
        self.goals, self.tolerance_m = np.array(list(goals.values())), tolerance_m
        self.observations = (
            *self.own_state,
            ObservationTerm(tuple(f"{CUBE}.{c}" for c in "xyz"), lambda at: at.now.cube),
            ObservationTerm(tuple(f"goal.{c}" for c in "xyz"), lambda at: at.goal),
        )

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: of the cube's centre, m."""
        return rng.uniform(*self.goals.T, (n, 3))

    def measure(self, batch, goal):
        """See `Rewarded.measure`."""
        grip = self.grip(batch)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        cube = batch.qpos[:, self.cube_qpos][:, :3]
        xp = namespace(cube)
        cube, grip = (xp.asarray(point, copy=True) for point in (cube, grip))
        return Measured(cube, grip, norm(grip - cube), norm(goal - cube))

    def success(self, at):
        """See `Rewarded.success`."""
        return at.now.goal_m < self.tolerance_m
