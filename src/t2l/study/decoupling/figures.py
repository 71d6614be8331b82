"""Effective stiffness over training, beside that of the bare controllers."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from t2l.plotting.style import COLOURS, styled, title

COLUMNS = ("update", "stiffness_n_m", "passive_n_m")


def stiffness_over_training(tables: Mapping[str, Mapping[int, pd.DataFrame]]) -> Figure:
    """A line a pairing: the median over directions and seeds, about it the half of them.

    Thin lines are seeds, each the median over directions; dashed is the bare controller.

    Args:
        tables: of each pairing's seeds, columns `COLUMNS`.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(5.2, 3.6))
        for colour, (name, seeds) in zip(COLOURS, tables.items(), strict=False):
            groups = pd.concat(seeds.values()).groupby("update").stiffness_n_m
            low, middle, high = (groups.quantile(share) for share in (0.25, 0.5, 0.75))
            axes.fill_between(middle.index, low, high, color=colour, alpha=0.2, lw=0)
            axes.plot(middle.index, middle, color=colour, lw=2, label=f"{title(name)}")
            for table in seeds.values():
                medians = table.groupby("update").stiffness_n_m.median()
                axes.plot(medians.index, medians, color=colour, lw=0.6)
            passive = next(iter(seeds.values())).passive_n_m.median()
            axes.axhline(passive, color=colour, ls="--", lw=1.2)
        axes.plot([], [], color="0.4", ls="--", lw=1.2, label="bare controller")
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("updates of the policy")
        axes.set_ylabel("effective stiffness |F|/|Δx| [N/m]")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2, fontsize=8)
        count = max(len(seeds) for seeds in tables.values())
        axes.set_title(f"Stiffness of the tool over training, {count} seed{'s'[: count > 1]}")
    return figure
