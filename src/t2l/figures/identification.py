"""What identification leaves: error over the grid, and measured against simulated motion."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from t2l.figures.heatmap import heatmap, height, matrix, width
from t2l.figures.style import COLOURS, short, styled
from t2l.gains import Cell, Grid

if TYPE_CHECKING:
    import pandas as pd

CELL_COLUMNS = ("kp", "kd", "mse_rad2", "loss", "on_bound")


def residual_error(cells: "pd.DataFrame", losses: Sequence["pd.DataFrame"], grid: Grid) -> Figure:
    """S* over the grid as an RMS error, and beside it how the search got there.

    Args:
        cells: one row a cell, columns `CELL_COLUMNS`.
        losses: for each cell, its least loss by iteration.
    """
    with styled():
        figure, axes = plt.subplots(1, 2, figsize=(width(grid), height(grid) + 0.6))
        error = 1e3 * np.sqrt(matrix(cells, "mse_rad2", grid))
        low, high = np.nanmin(error), np.nanmax(error)
        heatmap(
            axes[0],
            *(error, grid, "magma_r", LogNorm(low, max(high, low * 1.01))),
            text=lambda value: f"{value:.2g}",
            label="root of S* [mrad]",
            region="SO",
        )
        for (row, column), count in np.ndenumerate(matrix(cells, "on_bound", grid)):
            if count > 0:
                axes[0].text(
                    *(column + 0.47, row - 0.47, f"{count:.0f} on bound"),
                    ha="right", va="bottom", fontsize=5.5,
                )  # fmt: skip
        marked = {(cell.kp, cell.kd) for cell in grid.corners}
        corners = 0
        for table in losses:
            kp, kd = table.kp.iloc[0], table.kd.iloc[0]
            if (kp, kd) in marked:
                style = {"color": COLOURS[corners % len(COLOURS)], "label": str(Cell(kp, kd))}
                corners += 1
            else:
                style = {"color": "0.75", "lw": 0.8, "zorder": 1}
            axes[1].semilogy(table.iteration + 1, table.loss, **style)
        axes[1].set_xlabel("generation of CMA-ES")
        axes[1].set_ylabel("least spectral error [rad² + (rad/s)²]")
        axes[1].legend(fontsize=7)
        figure.suptitle("Identified training simulators", fontsize=11)
    return figure


def overlays(traces: Sequence["pd.DataFrame"]) -> Figure:
    """A column a cell, a row a joint: commanded, measured and simulated position."""
    with styled():
        joints = short(list(dict.fromkeys(traces[0].joint)))
        figure, axes = plt.subplots(
            *(len(joints), len(traces)),
            figsize=(2.5 * len(traces) + 0.8, 1.15 * len(joints) + 1.0),
            sharex=True,
            sharey="row",
            squeeze=False,
        )
        for column, trace in enumerate(traces):
            for row, (joint, label) in enumerate(joints.items()):
                part, panel = trace[trace.joint == joint], axes[row, column]
                panel.step(
                    *(part.time, part.q_des),
                    where="post", color="0.7", lw=0.8, label="commanded q_des",
                )  # fmt: skip
                measured = part.dropna(subset="q")
                panel.plot(measured.time, measured.q, color=COLOURS[0], lw=1.6, label="measured")
                panel.plot(
                    *(part.time, part.q_sim), color=COLOURS[1], lw=0.9, ls="--", label="identified"
                )
                if column == 0:
                    panel.set_ylabel(f"{label} [rad]", fontsize=8)
            cell = Cell(kp=trace.kp.iloc[0], kd=trace.kd.iloc[0])
            error = 1e3 * np.sqrt(np.mean((trace.q_sim - trace.q) ** 2))
            axes[0, column].set_title(f"{cell}\n{error:.2g} mrad RMS", fontsize=8)
            axes[-1, column].set_xlabel("time [s]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.align_ylabels()
        figure.suptitle("Measured and identified motion", fontsize=11)
    return figure
