"""What a trial of tuning chooses."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from t2l.robots import Robot


@dataclass(frozen=True)
class Choice:
    """What a trial chooses.

    Attributes:
        action_scale: α of each of the robot's groups of joints that share one, rad.
        reward_weights: of the task's reward, those that differ from its own.
    """

    action_scale: tuple[float, ...]
    reward_weights: Mapping[str, float] = field(default_factory=dict)


def scale_names(robot: Robot) -> list[str]:
    """What tables call the action scale of each group."""
    return [f"action_scale_{group}" for group in robot.scale_groups]
