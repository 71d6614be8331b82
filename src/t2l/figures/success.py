"""What behaviour cloning comes to over a grid of cells."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from t2l.gains import Grid
from t2l.plotting.heatmap import error_norm, heatmap, height, matrix, width
from t2l.plotting.style import styled

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("kp", "kd", "replay_success", "replays", "validation_loss", "success", "rollouts")


def success_and_loss(cells: "pd.DataFrame", grid: Grid, title: str) -> Figure:
    """Success rate of the cloned policy, and beside it its final validation loss.

    Args:
        cells: one row per policy, columns `COLUMNS`; successes are fractions.
    """
    with styled():
        figure, axes = plt.subplots(1, 2, figsize=(width(grid), height(grid)))
        policies = int(cells.groupby(["kp", "kd"]).size().max())
        n = int(cells.rollouts.max())
        of = f"{policies} × {n} rollouts" if policies > 1 else f"{n} rollouts"
        heatmap(
            axes[0],
            *(matrix(cells, "success", grid), grid, "viridis", Normalize(0, 1)),
            text=lambda v: f"{100 * v:.0f}",
            label=f"success [% of {of}]",
            percent=True,
        )
        losses = matrix(cells, "validation_loss", grid)
        heatmap(
            axes[1],
            *(losses, grid, "magma_r", error_norm(losses.flat)),
            text=lambda v: f"{v:.2g}".lstrip("0"),
            label="validation loss [normalised MSE]",
        )
        figure.suptitle(title, fontsize=11)
    return figure


def replay_success(cells: "pd.DataFrame", grid: Grid, title: str) -> Figure:
    """Share of demonstrations that still succeed after retargeting, per cell.

    Args:
        cells: one row per policy, columns `COLUMNS`; successes are fractions.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(width(grid) / 2, height(grid)))
        heatmap(
            axes,
            *(matrix(cells, "replay_success", grid), grid, "viridis", Normalize(0, 1)),
            text=lambda v: f"{100 * v:.0f}",
            label=f"replay success [% of {int(cells.replays.max())}]",
            percent=True,
        )
        figure.suptitle(title, fontsize=11)
    return figure
