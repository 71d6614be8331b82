"""Holding a pose while random forces push the tool: stiffly or softly, as the reward asks."""

from collections.abc import Mapping
from functools import cached_property

import mujoco
import numpy as np
from mujoco.batch import Batch
from pydantic import Field

from t2l.errors import ConfigurationError
from t2l.robots import make_robot
from t2l.tasks.bare_robot import bare_scene
from t2l.tasks.disturbance import RandomPushes, add_point
from t2l.tasks.task import Rewarded
from t2l.tasks.terms import Moment, ObservationTerm, RewardTerm, action_change, minus, state_of
from t2l.typed import Number, Typed


class PoseHoldParameters(Typed):
    """Of a pose to hold."""

    robot: str = Field("fr3", description="name of the robot, which is bare")
    tolerance_rad: Number = Field(
        0.1,
        gt=0,
        le=1,
        description="success is a distance from the pose below it at the end of an episode, over "
        "all joints, rad",
    )
    largest_force_n: Number = Field(
        30.0, ge=0, le=1000, description="pushes are up to this strong, N"
    )
    shortest_push_s: Number = Field(0.2, gt=0, le=60, description="the shortest push, s")
    longest_push_s: Number = Field(1.0, gt=0, le=60, description="the longest push, s")
    push_every_s: Number = Field(2.0, gt=0, le=60, description="there is one push in so long, s")


def near_the_pose(at: Moment) -> np.ndarray:
    """1 − tanh(‖q − g‖² / λ)."""
    return 1 - np.tanh((at.now**2).sum(axis=1) / at.task.weights["lambda_rad2"])


class PoseHold(Rewarded):
    """The robot's home is the pose g; a policy earns

        r = 1 − tanh(‖q − g‖² / λ) − α ‖Δa‖²

    at every step, the two rewards of the study's section III: a small λ and no α ask for a stiff
    behaviour, a large λ and an α for a compliant one. In `weights`, λ is `lambda_rad2` [rad²], and
    α `change`, per squared change of an action in [-1, 1].

    Raises:
        ConfigurationError: pushes are shorter than their shortest, or longer than what they are to
            fit in.
    """

    name = "pose_hold"
    instruction = "Hold the pose."
    # it is pushed to the end, so a behaviour that yields moves
    steady = False
    parameters = PoseHoldParameters
    rewards = (
        RewardTerm("hold", 1.0, near_the_pose, "the study, section III"),
        RewardTerm("change", 0.0, minus(action_change), "the study, section III"),
    )

    def __init__(
        self,
        robot: str,
        tolerance_rad: float,
        largest_force_n: float,
        shortest_push_s: float,
        longest_push_s: float,
        push_every_s: float,
    ):
        if not shortest_push_s <= longest_push_s <= push_every_s:
            raise ConfigurationError(
                f"longest_push_s: found {longest_push_s:g}; allowed: from shortest_push_s = "
                f"{shortest_push_s:g} to push_every_s = {push_every_s:g}"
            )
        self.robot, self.tolerance_rad = make_robot(robot), tolerance_rad
        self.largest_force_n, self.push_every_s = largest_force_n, push_every_s
        self.push_s = shortest_push_s, longest_push_s
        joints = self.robot.joints
        self.goal_size = len(joints)
        self.robot_observation_size = 2 * len(joints)
        self.observations = (
            *state_of(joints),
            ObservationTerm(tuple(f"error.{joint}" for joint in joints), lambda at: at.now),
        )

    def spec(self, visual: bool) -> mujoco.MjSpec:
        """See `Task.spec`."""
        spec = bare_scene(self.robot, visual)
        add_point(spec, self.robot.groups[0].tool_site)
        return spec

    def sample_starts(self, rng, n):
        """See `Task.sample_starts`: the pose itself."""
        return np.tile(self.robot.home, (n, 1))

    def sample_goals(self, rng, n):
        """See `Rewarded.sample_goals`: always the pose."""
        return np.tile(self.robot.home, (n, 1))

    def disturbance(self, batch: Batch, generator: np.random.Generator) -> RandomPushes:
        """See `Rewarded.disturbance`: pushes of the first group's tool."""
        return RandomPushes(batch, generator, self.largest_force_n, self.push_s, self.push_every_s)

    def measure(self, batch: Batch, goal):
        """See `Rewarded.measure`: what is left of the way to the pose, (n, njoint) rad."""
        return goal - batch.qpos[:, self.arm_qpos]

    def success(self, at):
        """See `Rewarded.success`."""
        return np.linalg.norm(at.now, axis=1) < self.tolerance_rad

    @cached_property
    def weights(self) -> Mapping[str, float]:
        """See `Rewarded.weights`; λ is among them."""
        return {**super().weights, "lambda_rad2": 0.01}
