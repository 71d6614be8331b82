"""The chosen trial of a cell on disk: YAML a person can read."""

from pathlib import Path
from typing import Any

import yaml

from t2l.artefacts import read_yaml, reading, write_text
from t2l.gains import Cell
from t2l.rl.choice import Choice
from t2l.rl.constraints import NAMES, Evaluation
from t2l.typed import describe, is_number


def write_chosen(
    path: Path | str, cell: Cell, number: int, choice: Choice, evaluation: Evaluation
) -> None:
    """Write which trial was the best, what it chose, and how its policy did in the simulator."""
    content = {
        "kp": cell.kp,
        "kd": cell.kd,
        "trial": number,
        "action_scale_rad": list(choice.action_scale),
        "reward_weights": dict(choice.reward_weights),
        "success": evaluation.success,
        "violation_rates": dict(evaluation.rates),
        "objective": evaluation.objective,
    }
    write_text(yaml.safe_dump(content, sort_keys=False), path)


def read_chosen(path: Path | str) -> tuple[Cell, Choice, Evaluation]:
    """Read what `write_chosen` wrote.

    Raises:
        ArtefactError: it is not that.
    """
    keys = ("kp", "kd", "action_scale_rad", "reward_weights", "success", "violation_rates")
    what = "the chosen trial of a cell"
    content = read_yaml(path, what, keys)
    with reading(path, what):
        proximal, distal = map(_number, content["action_scale_rad"])
        weights = {str(k): _number(v) for k, v in content["reward_weights"].items()}
        rates = {name: _number(content["violation_rates"][name]) for name in NAMES}
        return (
            Cell(_number(content["kp"]), _number(content["kd"])),
            Choice((proximal, distal), weights),
            Evaluation(_number(content["success"]), rates),
        )


def _number(value: Any) -> float:
    if not is_number(value):
        raise ValueError(f"found {describe(value)} where a number is expected")
    return float(value)
