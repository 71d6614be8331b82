"""The study's own grids of behaviour cloning, from the file of its project page.

The page draws its heatmaps from one file, which is not part of t2l: `ADDRESS`. It has five tasks,
7 stiffnesses by 8 dampings and 200 rollouts a cell. How its losses are normalised is not said.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from t2l import documents
from t2l.errors import InputError

# the commit at which it was read; 2 MB, most of them curves of losses
ADDRESS = (
    "https://raw.githubusercontent.com/younghyopark/tune-to-learn/"
    "3fc310b11ee50367eb26ae5db3c3036b8bf7e1af/static/js/training_heatmap_data.json"
)
COLUMNS = ("kp", "kd", "success", "replay_success", "loss")
# of a task of ours, by its kind; Block Stack is no task of the page's
COUNTERPARTS = {
    "mug_hanging": "Mug Hanging",
    "dishwasher": "Dishwasher Opening",
    "dishrack_loading": "Dish Rack Loading",
    "dishrack_unloading": "Dish Rack Unloading",
    "bimanual_handover": "Bimanual Handover",
}
_KEYS = {"success": "validation", "replay_success": "replay", "loss": "loss"}
_MOST_BYTES = 20_000_000


def read_grids(path: Path | str) -> dict[str, pd.DataFrame]:
    """Success of the study's policies, per task one row a cell with columns `COLUMNS`.

    Successes are fractions; `loss` is the last validation loss, in a unit that the page leaves out.

    Raises:
        InputError: the file is missing, or not what the page has; it says what is wrong.
    """
    whole = documents.read_json(path, "the study's published grids", _MOST_BYTES)
    tasks = whole.get("taskData") if isinstance(whole, dict) else None
    if not isinstance(tasks, dict) or not tasks:
        raise InputError(path, "taskData", "no tasks", f"the file of {ADDRESS}")
    return {name: _table(Path(path), name, task) for name, task in tasks.items()}


def _table(path: Path, name: str, task: Any) -> pd.DataFrame:
    where = f"taskData.{name}"
    if not isinstance(task, dict):
        raise InputError(path, where, "no object", "kps, kds, validation, replay, loss")
    kps, kds = (_numbers(path, f"{where}.{key}", task.get(key), 1) for key in ("kps", "kds"))
    columns = {"kp": np.tile(kps, len(kds)), "kd": np.repeat(kds, len(kps))}
    for column, key in _KEYS.items():
        values = _numbers(path, f"{where}.{key}", task.get(key), 2)
        if values.shape != (len(kds), len(kps)):
            found = f"{' by '.join(map(str, values.shape))} numbers"
            raise InputError(path, f"{where}.{key}", found, f"{len(kds)} by {len(kps)} of them")
        columns[column] = values.ravel()
    return pd.DataFrame(columns)


def _numbers(path: Path, where: str, found: Any, dimensions: int) -> np.ndarray:
    try:
        numbers = np.array(found, dtype=float)
    except (TypeError, ValueError):
        numbers = np.empty(())
    if numbers.ndim != dimensions or not np.isfinite(numbers).all():
        kind = "a list" if dimensions == 1 else "rows"
        raise InputError(path, where, "something else", f"{kind} of finite numbers")
    return numbers
