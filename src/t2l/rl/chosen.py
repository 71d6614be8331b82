"""The chosen trial of a cell on disk: YAML a person can read."""

from pathlib import Path

import yaml

from t2l.artefacts import reading, write_text
from t2l.gains import Cell
from t2l.rl.choice import Choice
from t2l.rl.constraints import Evaluation


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
    with reading(path, "chosen trial", "the rule choose_policy"):
        content = yaml.safe_load(Path(path).read_text())
        proximal, distal = map(float, content["action_scale_rad"])
        return (
            Cell(content["kp"], content["kd"]),
            Choice((proximal, distal), content["reward_weights"]),
            Evaluation(float(content["success"]), content["violation_rates"]),
        )
