"""Our grids of behaviour cloning beside the study's own, by the ranks of the cells both have.

Scenes, expert and policies differ, and the unit of the study's losses is not published, so nothing
but the order of the cells is compared.
"""

from collections.abc import Mapping

import pandas as pd

from t2l.names import heading
from t2l.stats.rank import rank_correlations
from t2l.stats.text import interval
from t2l.study.published.grids import COUNTERPARTS

# columns of ours, and of theirs that each is compared with
QUANTITIES = {"success": "success", "validation_loss": "loss", "validation_mse_rad2": "loss"}
NAMES = {
    "success": "success",
    "validation_loss": "validation loss, normalised",
    "validation_mse_rad2": "validation error, rad²",
}
CELLS = ("kp", "kd")
# of the table of cells: one row a cell and training seed
COLUMNS = (*CELLS, *QUANTITIES)


def published_grids_table(
    cells: Mapping[str, pd.DataFrame],
    kinds: Mapping[str, str],
    published: Mapping[str, pd.DataFrame],
) -> pd.DataFrame:
    """Spearman's ρ between a task's cells and those of its counterpart in the study.

    Args:
        cells: by task, one row a cell and training seed with columns `COLUMNS`; of seeds, the mean
            is compared.
        kinds: of each task, which say what its counterpart is; a task without one has no rows.
        published: by the study's name of a task, see `t2l.study.published.grids.read_grids`.

    Returns:
        One row a task and quantity: task, counterpart, quantity; rho with low, high, its 95 %
        bootstrap interval over `cells`, those that both have; seeds, the fewest in such a cell.
        NaN where it is undetermined.
    """
    rows = []
    for task, table in cells.items():
        name = COUNTERPARTS.get(kinds[task], "")
        if name not in published:
            continue
        both = _means(table).merge(published[name], on=CELLS, suffixes=("", "_theirs"))
        for ours, theirs in QUANTITIES.items():
            theirs = f"{theirs}_theirs" if theirs == ours else theirs
            found, _ = rank_correlations(
                {ours: both[ours].to_numpy()}, both[theirs].to_numpy(dtype=float)
            )
            one = found[ours]
            seeds = int(both.seeds.min()) if len(both) else 0
            rows.append((task, name, ours, one.rho, one.low, one.high, one.cells, seeds))
    columns = ["task", "counterpart", "quantity", "rho", "low", "high", "cells", "seeds"]
    return pd.DataFrame(rows, columns=columns)


def _means(table: pd.DataFrame) -> pd.DataFrame:
    """Over training seeds: a row a cell with columns `COLUMNS` and `seeds`."""
    means = {quantity: (quantity, "mean") for quantity in QUANTITIES}
    return table.groupby(list(CELLS), as_index=False).agg(**means, seeds=("success", "size"))


def printable_published_grids(table: pd.DataFrame) -> pd.DataFrame:
    """`published_grids_table` as text."""
    rho = zip(table.rho, table.low, table.high, strict=True)
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Task of the study": table.counterpart,
            "Quantity": [NAMES[name] for name in table.quantity],
            "ρ with the study's (95 %)": [interval(*row) for row in rho],
            "Cells": table.cells.astype(str),
            "Seeds": table.seeds.astype(str),
        }
    )
