"""The study's numbers of single cells, from its page."""

from functools import cache
from importlib.resources import files
from typing import Any

import pandas as pd
import yaml

from t2l.gains import Cell


@cache
def errors() -> pd.DataFrame:
    """E of transfer in 49 cells: kp, kd, published."""
    content = _content()["errors"]
    return pd.DataFrame(
        [
            {"kp": float(kp), "kd": float(kd), "published": 10.0**value}
            for kd, row in zip(content["kd"], content["log10_error"], strict=True)
            for kp, value in zip(content["kp"], row, strict=True)
        ]
    )


def passed_trials(task: str = "joint_reach") -> tuple[dict[Cell, int], int]:
    """Trials of a task with at least 95 % success by cell, and of how many they are.

    Of a task without published trials no cell is there.
    """
    content = _content()["trials"]
    of_task = content["passed"].get(task, {})
    passed = {Cell.from_name(name): number for name, number in of_task.items()}
    return passed, content["of"]


@cache
def _content() -> dict[str, Any]:
    text = (files("t2l.study.published") / "cells.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)
