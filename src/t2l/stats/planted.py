"""How often advice was right in planted worlds, against how often it says it is."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from t2l.stats.bootstrap import bootstrap_interval

# convention: share of success, within which of the best cell's nothing is lost
WITHIN = 0.05
NOMINAL, EXPLAINED = "nominal", "explained"  # what advice is given of the machine
COLUMNS = ("half", "known", "stated", "pairs", "worlds", "right", "low", "high")
BY = ["half", "known", "stated"]


def reliability(pairs: pd.DataFrame) -> pd.DataFrame:
    """Columns `COLUMNS`: of pairs of cells, the share in the right order, by the chance stated.

    The 95 % interval is over worlds, which are resampled with all their pairs.

    Args:
        pairs: world, half, known, stated, pairs (a count) and right (a share), a row a world.
    """
    rows = []
    for key, own in pairs.groupby(BY, sort=True):
        counts = own.pairs.to_numpy(float)
        right = counts * own.right.to_numpy()
        low, high = bootstrap_interval(_share, right, counts, paired=True)
        rows.append((*key, int(counts.sum()), len(own), right.sum() / counts.sum(), low, high))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _share(some: np.ndarray, counts: np.ndarray) -> np.ndarray:
    return some.sum(axis=-1) / counts.sum(axis=-1)


def losses(table: pd.DataFrame, rules: Mapping[str, str]) -> pd.DataFrame:
    """By how much rules fall short of the best cell: half, known, world, rule, lost.

    Args:
        table: best, and a column a rule, shares of success.
        rules: what they are called, by column.
    """
    named = table.rename(columns=rules).melt(
        ["half", "known", "world", "best"], [*rules.values()], "rule", "success"
    )
    return named.assign(lost=named.best - named.success)
