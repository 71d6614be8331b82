"""Training with every configuration that passed, at the corners of the grid."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.gains import Grid
from t2l.plotting.style import COLOURS, styled

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("configuration", "seed", "steps", "reward", "success", "kp", "kd")


def sample_efficiency(curves: "pd.DataFrame", grid: Grid) -> Figure:
    """Reward and success over training: mean over runs, band: from the 10th to the 90th percentile.

    Args:
        curves: columns `COLUMNS`.
    """
    with styled():
        figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.4), sharex=True)
        for colour, cell in zip(COLOURS, grid.corners, strict=False):
            part = curves[(curves.kp == cell.kp) & (curves.kd == cell.kd)]
            if not len(part):
                continue
            runs = part.groupby(["configuration", "seed"]).ngroups
            of = part.configuration.nunique()
            counted = f"{runs} run{'s'[: runs > 1]} of {of} configuration{'s'[: of > 1]}"
            label = f"{grid.region(cell)} {cell}: {counted}"
            for panel, key, scale in ((axes[0], "reward", 1), (axes[1], "success", 100)):
                groups = part.groupby("steps")[key]
                mean, low, high = (
                    scale * values
                    for values in (groups.mean(), groups.quantile(0.1), groups.quantile(0.9))
                )
                steps = mean.index / 1e6
                panel.plot(steps, mean, color=colour, label=label)
                panel.fill_between(steps, low, high, color=colour, alpha=0.2, lw=0)
        axes[0].set_ylabel("reward a second")
        axes[1].set_ylabel("success [%]")
        for panel in axes:
            panel.set_xlabel("environment steps [million]")
        if len(curves):
            figure.legend(
                *axes[0].get_legend_handles_labels(),
                loc="outside lower center",
                ncols=2,
                fontsize=8,
            )
        else:
            axes[0].text(
                0.5, 0.5, "nothing was trained again", transform=axes[0].transAxes, ha="center"
            )
        figure.suptitle("Training again with what passed", fontsize=11)
    return figure
