"""What the trials of a search say about the search itself: which of them pass, and pass again."""

from typing import TYPE_CHECKING

from t2l.rl.problem import Choice, scale_names
from t2l.robots import Robot
from t2l.study.passing import passes

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("number", "state", "success")
CURVE_COLUMNS = (
    "configuration", "seed", "update", "steps", "reward", "success", "kp", "kd",
)  # fmt: skip


def passed(trials: "pd.DataFrame", success: float, most: int) -> "pd.DataFrame":
    """The complete trials that pass a success rate: the first `most` of them.

    The first, and not the best: these would be the luckiest.

    Args:
        trials: columns `COLUMNS` and those of what was chosen.
    """
    good = trials[(trials.state == "complete") & passes(trials.success, success)]
    return good.sort_values("number").head(most)


def choice_of(trial: "pd.Series", robot: Robot, weights: tuple[str, ...]) -> Choice:
    """What a trial of a table chose.

    Args:
        weights: names of those of the reward that the search had.
    """
    scales = tuple(float(trial[name]) for name in scale_names(robot))
    return Choice(scales, {name: float(trial[name]) for name in weights})


def no_curve() -> "pd.DataFrame":
    """The table of a configuration that there is none of."""
    import pandas as pd

    return pd.DataFrame({name: pd.Series(dtype=float) for name in CURVE_COLUMNS})
