"""What variants of behaviour cloning do to success in each region of gains."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from t2l.names import heading
from t2l.plotting.style import COLOURS, styled

if TYPE_CHECKING:
    import pandas as pd

REGIONS = {
    "co": "compliant, overdamped",
    "so": "stiff, overdamped",
    "cu": "compliant, underdamped",
    "su": "stiff, underdamped",
}


def variants(table: "pd.DataFrame") -> Figure:
    """A row a variant, a point a region: mean over cells, line: 95 % interval over cells.

    Args:
        table: as `t2l.stats.regions.region_table` makes it.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(6.8, 1.3 + 0.42 * len(table)))
        at = np.arange(len(table))[::-1]
        for i, (key, label) in enumerate(REGIONS.items()):
            mean = table[f"success_{key}"].to_numpy()
            ends = np.abs(table[[f"lower_{key}", f"upper_{key}"]].to_numpy().T - mean)
            axes.errorbar(
                *(mean, at + 0.15 * (1.5 - i)),
                xerr=np.nan_to_num(ends),
                fmt="o", ms=4, lw=1.2, color=COLOURS[i], label=label,
            )  # fmt: skip
        axes.set_yticks(at, [heading(name) for name in table.name])
        axes.set_ylim(-0.6, len(table) - 0.4)
        axes.set_xlim(0, 1)
        axes.xaxis.set_major_formatter(PercentFormatter(1))
        cells, seeds = int(table.cells.max()), int(table.seeds.min())
        policies = "policies" if seeds > 1 else "policy"
        axes.set_xlabel(f"success, mean over cells ({cells} cells, {seeds} {policies} each)")
        axes.grid(axis="x", lw=0.4)
        figure.legend(loc="outside upper center", ncols=2, fontsize=8)
    return figure
