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


def passed_trials() -> tuple[dict[Cell, int], int]:
    """Trials of Joint-Reach with at least 95 % success by cell, and of how many they are."""
    content = _content()["trials"]
    passed = {Cell.from_name(name): number for name, number in content["passed"].items()}
    return passed, content["of"]


@cache
def _content() -> dict[str, Any]:
    text = (files("t2l.study.published") / "cells.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)
