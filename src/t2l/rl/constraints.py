"""How episodes went, and what a policy that is to be deployed must not do."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from t2l.environment.limits import LIMITS

# largest tolerated share of episodes, the study's (App. G); jitter is no constraint of its search
TOLERATED = {"position": 0.0, "velocity": 0.0, "torque": 0.0, "torque_rate": 0.2}


@dataclass(frozen=True)
class Evaluation:
    """How episodes went.

    Attributes:
        success: share of episodes at the goal at their end, without jitter.
        rates: by name in `t2l.environment.limits.NAMES`, the share of episodes that violated it at
            any instant.
        failed: share of episodes that ended before their time, such as by a fall.
    """

    success: float
    rates: Mapping[str, float]
    failed: float = 0.0

    @property
    def feasible(self) -> bool:
        """Whether the rate of every limit is tolerated."""
        return all(self.rates[name] <= TOLERATED[name] for name in LIMITS)

    @property
    def objective(self) -> float:
        """The study's two-stage objective of a trial, 0 to 2.

        1 + success where every rate is tolerated, else success · Π max(0, 1 − (v_c − v̄_c)) over
        the constraints c that are not.
        """
        excess = [self.rates[name] - TOLERATED[name] for name in LIMITS]
        if self.feasible:
            return 1.0 + self.success
        return self.success * math.prod(max(0.0, 1.0 - max(0.0, value)) for value in excess)

    def value(self, solved_at: float | None = None) -> float:
        """What a search ranks a trial by: the objective, or 0 to 3 with the task before the limits.

        Args:
            solved_at: with less success than this, a trial is worth its success alone; others are
                worth 1 + the objective, and so more than any of these.
        """
        if solved_at is None:
            return self.objective
        return self.success if self.success < solved_at else 1.0 + self.objective
