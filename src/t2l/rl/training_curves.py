"""How reward and success grow over training."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from t2l.rl.choice import Choice
from t2l.rl.problem import Problem
from t2l.rl.registry import ALGORITHMS
from t2l.rl.settings import Settings

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("update", "steps", "reward", "success", "objective")
EPISODES = 50


def curve(problem: Problem, choice: Choice, settings: Settings, threads: int = 1) -> "pd.DataFrame":
    """One row an evaluation, over the whole length of training, columns `COLUMNS`."""
    # no success rate ends it
    whole_length = replace(settings, enough=np.inf)
    trained = ALGORITHMS.find(settings.algorithm)().train(
        problem.environments(choice, settings.environments, settings.seed, True, threads),
        problem.environments(choice, EPISODES, settings.seed + 1, threads=threads),
        whole_length,
        threads=threads,
    )
    return trained.history[list(COLUMNS)]


def no_curve() -> "pd.DataFrame":
    """The table of a cell whose policy did not pass."""
    import pandas as pd

    return pd.DataFrame({name: [] for name in COLUMNS}, dtype=float)
