"""What a search of gains came to: a table of its trials, the front, and the front in words.

It loads without torch.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from t2l.rl.trials import FINISHED, INTERNAL

if TYPE_CHECKING:
    import optuna
    import pandas as pd

AGAIN = "again"  # of a study's attributes, what a trial that was trained again came to


def gain_table(study: "optuna.Study", objectives: Mapping[str, str]) -> "pd.DataFrame":
    """One row a finished trial: what it chose and came to, whether it is feasible, in the front.

    Objectives of a trial that was trained again stand beside it with `_again`, as means; a training
    that left no policy counts there as one without success.

    Args:
        objectives: their directions by name, as of Optuna.
    """
    import pandas as pd

    rows = []
    for trial in study.get_trials(deepcopy=False, states=FINISHED):
        known = {k: v for k, v in trial.user_attrs.items() if k not in INTERNAL}
        own = {"number": trial.number, **trial.params, **known}
        own["feasible"] = max(trial.constraints.values()) <= 0
        again = [v for k, v in study.user_attrs.items() if k.startswith(f"{AGAIN}/{trial.number}/")]
        own["again"] = len(again)
        for name in objectives if again else ():
            found = [one.get(name, 0.0 if name == "success" else math.nan) for one in again]
            own[f"{name}_again"] = np.mean(found) if name == "success" else _mean(found)
        rows.append(own)
    table = pd.DataFrame(rows)
    for name in objectives:
        if name not in table:
            table[name] = math.nan
    signs = [-1.0 if direction == "maximize" else 1.0 for direction in objectives.values()]
    costs = table[list(objectives)].to_numpy(float) * signs
    return table.assign(front=not_beaten(costs, table.feasible if len(table) else []))


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan


def not_beaten(costs: np.ndarray, allowed: Sequence[bool]) -> np.ndarray:
    """(n,) bool: which allowed rows of costs (n, k) are in the Pareto front.

    A row is beaten by an allowed one that is nowhere worse and somewhere better.
    """
    allowed = np.array(allowed, bool) & np.isfinite(costs).all(axis=1)
    rivals = costs[allowed]
    beaten = [
        bool(((rivals <= own).all(axis=1) & (rivals < own).any(axis=1)).any()) for own in costs
    ]
    return allowed & ~np.array(beaten, bool)


def in_words(trials: "pd.DataFrame", objectives: Mapping[str, str]) -> str:
    """The front for a terminal, the best success first; what is missing if there is none."""
    front = trials[trials.front].sort_values("success", ascending=False)
    if not len(front):
        return (
            f"No trial of {len(trials)} is allowed: each breaks a limit or succeeds too rarely; "
            "trials.csv says which. Try more trials, more updates, wider bounds or fewer limits."
        )
    scales = [name for name in front if name.startswith("action_scale_")]
    again = [f"{name}_again" for name in objectives if f"{name}_again" in front]
    shown = front[["number", "kp", "kd", *scales, *objectives, *again]]
    text = shown.to_string(index=False, float_format=lambda value: f"{value:.3g}")
    return f"The front, {len(front)} of {len(trials)} trials:\n{text}"
