"""By how much compliance helps, in each collection of demonstrations and starts."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.names import heading
from t2l.plotting.style import COLOURS, styled
from t2l.stats.collections import contrast

if TYPE_CHECKING:
    import pandas as pd


def collections(table: "pd.DataFrame", cells: "Mapping[str, pd.DataFrame]") -> Figure:
    """A row a variant: a dot a collection, CO less SO, and the mean with its 95 % interval.

    Args:
        table: as `t2l.stats.collections.collections_table` makes it.
        cells: by name of a variant, as `by_collection` of that module makes it.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(6.8, 1.2 + 0.32 * len(table)))
        at = np.arange(len(table))[::-1]
        for y, row in zip(at, table.itertuples(), strict=True):
            each = 100 * contrast(cells[row.name], ["SO"])
            axes.plot(each, np.full(len(each), y - 0.18), "o", ms=3, color=COLOURS[1], alpha=0.7)
        mean = 100 * table.co_so.to_numpy()
        ends = np.abs(100 * table[["co_so_lower", "co_so_upper"]].to_numpy().T - mean)
        axes.errorbar(
            mean, at + 0.1, xerr=np.nan_to_num(ends), fmt="D", ms=5, lw=1.5, color=COLOURS[0]
        )
        axes.axvline(0, color="black", lw=0.6)
        counts = zip(table.name, table.collections, strict=True)
        axes.set_yticks(at, [f"{heading(name)} ({n})" for name, n in counts])
        axes.set_ylim(-0.6, len(table) - 0.4)
        axes.set_xlabel("success of CO less success of SO, per cent points")
        axes.grid(axis="x", lw=0.4)
    return figure
