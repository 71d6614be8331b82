"""The two reaching tasks: what a goal is, what a policy sees, what it is paid for."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType

import numpy as np

from t2l.errors import ConfigurationError
from t2l.identify.training_simulator import model
from t2l.robots.fr3 import JOINTS
from t2l.robots.kinematics import Flange

# Where the study's 49 recordings start, to a few mrad; starts and goals are drawn about it.
CENTRE = (0.0, 0.0, 0.0, -np.pi / 2, 0.0, np.pi / 2, -np.pi / 4)
START_SPREAD_RAD = 0.1
GOAL_SPREAD_RAD = 0.4
MARGIN_RAD = 0.1  # of goals from the ends of the ranges


@cache
def joint_ranges() -> np.ndarray:
    """(7, 2) rad, read-only."""
    ranges = model().jnt_range.copy()
    ranges.flags.writeable = False
    return ranges


@cache
def _goal_bounds() -> tuple[np.ndarray, np.ndarray]:
    inner = (joint_ranges() + np.array([MARGIN_RAD, -MARGIN_RAD])).T
    low, high = (np.clip(np.array(CENTRE) + s * GOAL_SPREAD_RAD, *inner) for s in (-1, 1))
    return low, high


class Reach(ABC):
    """A goal to reach and hold; success is judged at the end of an episode.

    Attributes:
        name: what configurations write.
        goal_size, errors_size: numbers in a goal, and in what is left to do.
        weights: of the reward's terms.
    """

    name: str
    goal_size: int
    errors_size: int
    weights: Mapping[str, float]

    def sample_starts(self, generator: np.random.Generator, n: int) -> np.ndarray:
        """(n, 7) rad."""
        return np.array(CENTRE) + generator.normal(0.0, START_SPREAD_RAD, (n, len(JOINTS)))

    def sample_joint_goals(self, generator: np.random.Generator, n: int) -> np.ndarray:
        """(n, 7) rad, within the ranges, each joint uniform about the centre."""
        return generator.uniform(*_goal_bounds(), (n, len(JOINTS)))

    @abstractmethod
    def sample_goals(self, generator: np.random.Generator, n: int) -> np.ndarray:
        """(n, goal_size), all reachable."""

    @abstractmethod
    def errors(self, q: np.ndarray, pose: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """(n, errors_size) what is left to do, signed.

        Args:
            q: (n, 7) rad.
            pose: (n, 12) of the flange: position in m and rotation matrix.
        """

    @abstractmethod
    def success(self, errors: np.ndarray) -> np.ndarray:
        """(n,) bool."""

    @abstractmethod
    def reward(
        self,
        before: np.ndarray,
        errors: np.ndarray,
        period_s: float,
        dq: np.ndarray,
        change: np.ndarray,
    ) -> np.ndarray:
        """What a step is worth, (n,).

        The term `progress` is the rate at which a potential of the errors falls, which credits an
        action at once and moves no optimum (Ng, Harada and Russell, 1999).

        Args:
            before, errors: (n, errors_size) before and after the step.
            period_s: of the step.
            dq: (n, 7) rad/s, after it.
            change: (n, 7), by how much the action differs from the one before.
        """


@dataclass(frozen=True)
class JointReach(Reach):
    """Success: ‖q − q_goal‖ < 0.1 rad."""

    name = "joint_reach"
    goal_size = 7
    errors_size = 7
    weights: Mapping[str, float] = field(
        default_factory=lambda: {
            "distance": 0.4, "near": 1.0, "progress": 2.0, "velocity": 0.1, "change": 0.02
        }
    )  # fmt: skip
    tolerance_rad: float = 0.1

    def sample_goals(self, generator, n):
        """See `Reach`."""
        return self.sample_joint_goals(generator, n)

    def errors(self, q, pose, goal):
        """See `Reach`: (n, 7) rad."""
        return goal - q

    def success(self, errors):
        """See `Reach`."""
        return np.linalg.norm(errors, axis=1) < self.tolerance_rad

    def reward(self, before, errors, period_s, dq, change):
        """See `Reach`."""
        near, w = self.tolerance_rad / 2, self.weights
        rate = (np.tanh(errors / near) * (before - errors)).sum(axis=1) / period_s
        return (
            -w["distance"] * np.abs(errors).sum(axis=1)
            + w["near"] * np.exp(-((errors / near) ** 2)).mean(axis=1)
            + w["progress"] * rate
            - w["velocity"] * (dq**2).sum(axis=1)
            - w["change"] * (change**2).sum(axis=1)
        )


@dataclass(frozen=True)
class EndEffectorReach(Reach):
    """Success: flange within 0.02 m of the goal's position and 0.1 rad of its orientation."""

    name = "end_effector_reach"
    goal_size = 12
    errors_size = 6
    weights: Mapping[str, float] = field(
        default_factory=lambda: {
            "position": 4.0, "orientation": 1.0, "near": 1.0, "progress": 1.0,
            "velocity": 0.1, "change": 0.02,
        }
    )  # fmt: skip
    position_tolerance_m: float = 0.02
    orientation_tolerance_rad: float = 0.1

    def sample_goals(self, generator, n):
        """See `Reach`: poses of sampled joint positions, so that all can be reached."""
        return Flange(n).pose(self.sample_joint_goals(generator, n))

    def errors(self, q, pose, goal):
        """See `Reach`: (n, 6), m and the rotation vector in rad."""
        here, there = pose[:, 3:].reshape(-1, 3, 3), goal[:, 3:].reshape(-1, 3, 3)
        return np.concatenate(
            [goal[:, :3] - pose[:, :3], rotation_vector(there @ here.transpose(0, 2, 1))], axis=1
        )

    def success(self, errors):
        """See `Reach`."""
        away, turned = self._sizes(errors)
        return (away < self.position_tolerance_m) & (turned < self.orientation_tolerance_rad)

    def reward(self, before, errors, period_s, dq, change):
        """See `Reach`; progress is weighed as distance is."""
        w = self.weights
        away, turned = self._sizes(errors)
        was_away, was_turned = self._sizes(before)
        near = np.exp(-((away / self.position_tolerance_m) ** 2)) + np.exp(
            -((turned / self.orientation_tolerance_rad) ** 2)
        )
        rate = w["position"] * (was_away - away) + w["orientation"] * (was_turned - turned)
        return (
            -w["position"] * away
            - w["orientation"] * turned
            + w["near"] * near / 2
            + w["progress"] * rate / period_s
            - w["velocity"] * (dq**2).sum(axis=1)
            - w["change"] * (change**2).sum(axis=1)
        )

    @staticmethod
    def _sizes(errors):
        return np.linalg.norm(errors[:, :3], axis=1), np.linalg.norm(errors[:, 3:], axis=1)


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Axis times angle (n, 3) rad of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()


TASKS: dict[str, type[Reach]] = {task.name: task for task in (JointReach, EndEffectorReach)}


def make_task(name: str, weights: Mapping[str, float] = MappingProxyType({})) -> Reach:
    """A task by its name, with some of its reward's weights replaced.

    Raises:
        ConfigurationError: the reward has no such weight.
    """
    own = TASKS[name]().weights
    unknown = [weight for weight in weights if weight not in own]
    if unknown:
        raise ConfigurationError(
            f"reward weights of {name}: found {', '.join(unknown)}; allowed: {', '.join(own)}"
        )
    return TASKS[name](weights={**own, **weights})
