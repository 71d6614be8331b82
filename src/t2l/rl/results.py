"""What learning came to: how episodes went, what was chosen, and both as YAML a person can read.

The study's objective asks whether a policy that is to be deployed does what it must not.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from t2l.artefacts import read_yaml, reading, write_text
from t2l.environment.limits import LIMITS, NAMES
from t2l.gains import Cell
from t2l.rl.problem import Choice
from t2l.typed import describe, is_number

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
        jitter_rad_s, effort: means over episodes, see `t2l.environment.environment.Ended`.
    """

    success: float
    rates: Mapping[str, float]
    failed: float = 0.0
    jitter_rad_s: float = math.nan
    effort: float = math.nan

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


def write_chosen(path: Path | str, cell: Cell, choice: Choice, how: str) -> None:
    """Write what is to be trained with, and `how` it was found, in words."""
    content = {
        "kp": cell.kp,
        "kd": cell.kd,
        "found": how,
        "action_scale_rad": list(choice.action_scale),
        "reward_weights": dict(choice.reward_weights),
    }
    write_text(yaml.safe_dump(content, sort_keys=False), path)


def read_chosen(path: Path | str) -> tuple[Cell, Choice]:
    """Read what `write_chosen` wrote.

    Raises:
        ArtefactError: it is not that.
    """
    what = "what was chosen for a cell"
    content = read_yaml(path, what, ("kp", "kd", "action_scale_rad", "reward_weights"))
    with reading(path, what):
        scales = tuple(map(_number, content["action_scale_rad"]))
        weights = {str(k): _number(v) for k, v in content["reward_weights"].items()}
        return Cell(_number(content["kp"]), _number(content["kd"])), Choice(scales, weights)


def write_outcome(path: Path | str, evaluation: Evaluation, feedback_gain: float) -> None:
    """Write how a trained policy does in its simulator, and its `t2l.rl.feedback` gain."""
    content = {
        "success": evaluation.success,
        "feasible": evaluation.feasible,
        "violation_rates": dict(evaluation.rates),
        "objective": evaluation.objective,
        "feedback_gain": feedback_gain,
    }
    write_text(yaml.safe_dump(content, sort_keys=False), path)


def read_outcome(path: Path | str) -> tuple[Evaluation, float]:
    """Read what `write_outcome` wrote.

    Raises:
        ArtefactError: it is not that.
    """
    what = "what a policy came to"
    content = read_yaml(path, what, ("success", "violation_rates", "feedback_gain"))
    with reading(path, what):
        rates = {name: _number(content["violation_rates"][name]) for name in NAMES}
        return Evaluation(_number(content["success"]), rates), _number(content["feedback_gain"])


def _number(value: Any) -> float:
    if not is_number(value):
        raise ValueError(f"found {describe(value)} where a number is expected")
    return float(value)
