"""What was chosen for a cell, and what a policy came to, on disk: YAML a person can read."""

from pathlib import Path
from typing import Any

import yaml

from t2l.artefacts import read_yaml, reading, write_text
from t2l.environment.limits import NAMES
from t2l.gains import Cell
from t2l.rl.choice import Choice
from t2l.rl.constraints import Evaluation
from t2l.typed import describe, is_number


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
