"""How tuning and training went at the corners of the grid."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from t2l.gains import Cell, Grid
from t2l.plotting.style import COLOURS, styled, title

if TYPE_CHECKING:
    import pandas as pd

TRIAL_COLUMNS = ("state", "success", "kp", "kd")
SCALE = "action_scale_"  # and the group of joints that it belongs to
CURVE_COLUMNS = ("steps", "reward", "success", "kp", "kd", "seed")


def landscape(trials: Mapping[Cell, "pd.DataFrame"], grid: Grid) -> Figure:
    """A panel a corner: success of every trial over the action scales of two groups of joints.

    Args:
        trials: of each corner, columns `TRIAL_COLUMNS` and a scale per group of joints, of which
            the first and the last are drawn.
    """
    if not trials:
        with styled():
            return _nothing("no trials: the action scales are given")
    columns = next(iter(trials.values())).columns
    scales = [name for name in columns if name.startswith(SCALE) and not name.endswith("_share")]
    across, upward = scales[0], scales[-1]
    with styled():
        figure, axes = plt.subplots(
            1, len(trials), figsize=(2.6 * len(trials) + 1.2, 3.2),
            sharex=True, sharey=True, squeeze=False,
        )  # fmt: skip
        shown, states = None, {}
        for panel, (cell, table) in zip(axes[0], trials.items(), strict=True):
            known = table.dropna(subset=["success", *scales])
            for state, marker in (("complete", "o"), ("pruned", "X")):
                part = known[known.state == state]
                if len(part):
                    shown = panel.scatter(
                        part[across], part[upward],
                        c=100 * part.success, vmin=0, vmax=100, cmap="viridis",
                        marker=marker, s=28, ec="0.3", lw=0.5,
                    )  # fmt: skip
                    states[state] = Line2D([], [], ls="", marker=marker, c="0.5", label=state)
            panel.set_xscale("log")
            panel.set_yscale("log")
            panel.set_title(f"{grid.region(cell)}: {cell}", fontsize=9)
            panel.set_xlabel(_scale(across))
        axes[0, 0].set_ylabel(_scale(upward))
        if shown is not None:
            figure.colorbar(shown, ax=axes[0].tolist(), label="success in simulation [%]")
            figure.legend(handles=states.values(), loc="outside lower center", ncols=2, fontsize=8)
        figure.suptitle("Trials of tuning", fontsize=11)
    return figure


def _nothing(why: str) -> Figure:
    figure, panel = plt.subplots(figsize=(5, 2))
    panel.set_axis_off()
    panel.text(0.5, 0.5, why, ha="center", transform=panel.transAxes)
    return figure


def _scale(name: str) -> str:
    return f"α of {name.removeprefix(SCALE).replace('_', ' ')} joints [rad]"


def training_curves(curves: Mapping[str, "pd.DataFrame"], grid: Grid) -> Figure:
    """A column a condition: reward and success over training, mean and deviation over seeds.

    Args:
        curves: of each condition, columns `CURVE_COLUMNS`.
    """
    with styled():
        figure, axes = plt.subplots(
            2, len(curves), figsize=(2.7 * len(curves) + 1.0, 4.4),
            sharex="col", sharey="row", squeeze=False,
        )  # fmt: skip
        for column, (name, table) in enumerate(curves.items()):
            for colour, cell in zip(COLOURS, grid.corners, strict=False):
                part = table[(table.kp == cell.kp) & (table.kd == cell.kd)]
                if not len(part):
                    continue
                label = f"{grid.region(cell)} {cell}"
                for row, key, scale in ((0, "reward", 1), (1, "success", 100)):
                    mean = scale * part.groupby("steps")[key].mean()
                    spread = scale * part.groupby("steps")[key].std(ddof=0)
                    steps = mean.index / 1e6
                    axes[row, column].plot(steps, mean, color=colour, label=label)
                    axes[row, column].fill_between(
                        steps, mean - spread, mean + spread, color=colour, alpha=0.2, lw=0
                    )
            axes[0, column].set_title(title(name), fontsize=9)
            axes[1, column].set_xlabel("environment steps [million]")
            if not len(table):
                axes[0, column].text(
                    0.5, 0.5, "no cell passed", transform=axes[0, column].transAxes, ha="center"
                )
        axes[0, 0].set_ylabel("reward a second")
        axes[1, 0].set_ylabel("success [%]")
        handles, labels = [], []
        for panel in axes[0]:
            for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
                if label not in labels:
                    handles, labels = [*handles, handle], [*labels, label]
        if handles:
            figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=8)
        seeds = len(np.unique(np.concatenate([t.seed for t in curves.values()])))
        figure.suptitle(
            f"Training with tuned action scales, {seeds} seed{'s' if seeds > 1 else ''}",
            fontsize=11,
        )
    return figure
