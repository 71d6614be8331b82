"""How success grows with the number of demonstrations, by region of gains."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, PercentFormatter

from t2l.figures.variants import REGIONS
from t2l.names import heading
from t2l.plotting.style import COLOURS, styled

if TYPE_CHECKING:
    import pandas as pd


def scaling(tables: "Mapping[str, pd.DataFrame]") -> Figure:
    """A panel a task, a line a region: mean over cells, band: 95 % interval over cells.

    Args:
        tables: of each task, as `t2l.stats.scaling.scaling_table` makes it.
    """
    with styled():
        figure, axes = plt.subplots(
            1, len(tables), figsize=(1.2 + 3.8 * len(tables), 3.6), sharey=True, squeeze=False
        )
        for panel, (task, table) in zip(axes[0], tables.items(), strict=True):
            for i, (key, label) in enumerate(REGIONS.items()):
                own = table[table.region == key.upper()]
                if own.empty:
                    continue
                panel.plot(
                    own.demonstrations, own.success, "o-", ms=4, color=COLOURS[i], label=label
                )
                ends = own[["lower", "upper"]].to_numpy(float).T
                panel.fill_between(
                    own.demonstrations, *np.nan_to_num(ends), color=COLOURS[i], alpha=0.15, lw=0
                )
            panel.set_xscale("log", base=2)
            numbers = sorted(table.demonstrations.unique())
            panel.set_xticks(numbers, [f"{number}" for number in numbers])
            panel.xaxis.set_minor_locator(NullLocator())
            panel.set_title(heading(task))
            panel.set_xlabel("demonstrations")
            panel.grid(lw=0.4)
        axes[0, 0].set_ylim(0, 1)
        axes[0, 0].yaxis.set_major_formatter(PercentFormatter(1))
        axes[0, 0].set_ylabel("success, mean over cells")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=8)
    return figure
