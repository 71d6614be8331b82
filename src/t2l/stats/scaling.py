"""How success grows with the number of demonstrations."""

import numpy as np
import pandas as pd

from t2l.gains import Cell, Grid
from t2l.stats.bootstrap import bootstrap_interval, mean
from t2l.stats.regions import REGIONS
from t2l.stats.text import rate

COLUMNS = ("kp", "kd", "success", "demonstrations")


def by_size(cells: pd.DataFrame) -> pd.DataFrame:
    """Success, the mean over policies: a row a cell (kp, kd), a column a number of demonstrations.

    Args:
        cells: one row a policy, columns `COLUMNS`. Cells that lack a number are left out.
    """
    table = cells.pivot_table(
        index=["kp", "kd"], columns="demonstrations", values="success", aggfunc="mean"
    )
    return table.dropna()


def slopes(success: pd.DataFrame) -> np.ndarray:
    """(n,) change of success per doubling of the demonstrations, least squares a cell.

    Args:
        success: as `by_size` makes it.
    """
    x = np.log2(np.asarray(success.columns, float))
    x = x - x.mean()
    return (success.to_numpy() @ x) / (x @ x)


def scaling_table(cells: pd.DataFrame, grid: Grid) -> pd.DataFrame:
    """Success in each region at each number of demonstrations, and its slope.

    Args:
        cells: as of `by_size`.

    Returns:
        A row a region and number: region, cells, demonstrations; success, the mean over cells,
        lower, upper, its 95 % bootstrap interval over cells; slope, slope_lower, slope_upper, the
        region's change of success per doubling, the same in its rows.
    """
    table = by_size(cells)
    region = np.array([grid.region(Cell(kp, kd)) for kp, kd in table.index])
    rows = []
    for word in REGIONS:
        own = table[region == word]
        if own.empty:
            continue
        slope = slopes(own)
        low, high = bootstrap_interval(mean, slope)
        for number in own.columns:
            values = own[number].to_numpy()
            lower, upper = bootstrap_interval(mean, values)
            rows.append(
                (word, len(own), int(number), values.mean(), lower, upper, slope.mean(), low, high)
            )
    columns = ["region", "cells", "demonstrations", "success", "lower", "upper"]
    return pd.DataFrame(rows, columns=[*columns, "slope", "slope_lower", "slope_upper"])


def printable_scaling(table: pd.DataFrame) -> pd.DataFrame:
    """The table as text: a row a region."""
    rows = []
    for (word, n), own in table.groupby(["region", "cells"], sort=False):
        first = own.iloc[0]
        row = {"Region": f"{word} ({n} {'cell' if n == 1 else 'cells'})"}
        row |= {
            f"{number} demonstrations": rate(success)
            for number, success in zip(own.demonstrations, own.success, strict=True)
        }
        row["Per doubling"] = (
            f"{100 * first.slope:+.1f} points "
            f"({100 * first.slope_lower:+.1f} to {100 * first.slope_upper:+.1f})"
        )
        rows.append(row)
    return pd.DataFrame(rows)
