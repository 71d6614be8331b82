"""What a trial of tuning chooses."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Choice:
    """What a trial chooses.

    Attributes:
        action_scale: α of proximal joints and of the others, rad.
        reward_weights: of the task's reward, those that differ from its own.
    """

    action_scale: tuple[float, float]
    reward_weights: Mapping[str, float] = field(default_factory=dict)
