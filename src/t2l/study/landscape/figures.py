"""Existence at the corners of the grid, and training with every configuration that passed."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.gains import Grid
from t2l.plotting.style import COLOURS, styled, title
from t2l.study.published.numbers import REGIONS

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("configuration", "seed", "steps", "reward", "success", "kp", "kd")


def existence(table: "pd.DataFrame") -> Figure:
    """A row a task, a column a corner: success in fresh episodes; a frame where a policy exists.

    Args:
        table: of `t2l.study.landscape.existence.existence_table`.
    """
    tasks = list(table.task.unique())
    success = table.pivot(index="task", columns="region", values="success")
    shares = success.reindex(index=tasks, columns=list(REGIONS)).to_numpy(float)
    with styled():
        figure, axes = plt.subplots(figsize=(6.4, 1.2 + 0.5 * len(tasks)))
        image = axes.imshow(100 * shares, cmap="viridis", vmin=0, vmax=100, aspect="auto")
        for one in table.itertuples():
            x, y = REGIONS.index(one.region), tasks.index(one.task)
            colour = "black" if one.success > 0.6 else "white"
            text = f"{100 * one.success:.1f} %"
            if one.published_trials > 0:
                text += f"\n{one.published_passed:.0f} of {one.published_trials:.0f} trials"
            axes.text(x, y, text, ha="center", va="center", color=colour, fontsize=8)
            if one.exists:
                axes.add_patch(
                    plt.Rectangle((x - 0.47, y - 0.45), 0.94, 0.9, fill=False, ec=COLOURS[1], lw=2)
                )
        axes.set_xticks(range(len(REGIONS)), REGIONS)
        axes.set_yticks(range(len(tasks)), [title(task) for task in tasks])
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0)
        figure.colorbar(image, ax=axes, label="success in fresh episodes [%]")
        axes.set_title("Framed: 99 % or more. Trials: the study's with 95 % or more", fontsize=9)
    return figure


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
