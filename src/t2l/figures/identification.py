"""What identification leaves: error over the grid, and measured against simulated motion."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from t2l.figures.heatmap import error_norm, heatmap, height, matrix, width
from t2l.figures.style import COLOURS, plain, short, styled
from t2l.gains import Cell, Grid

if TYPE_CHECKING:
    import pandas as pd

CELL_COLUMNS = ("kp", "kd", "mse_rad2", "s_star", "loss", "on_bound")
NUMBERED = 16  # cells at most whose numbers can be read side by side
# what was made small, and in what steps, by whether gains were free
SEARCHES = {
    "free": ("generation of CMA-ES", "least spectral error [rad² + (rad/s)²]"),
    "known": ("round of least squares", "mean squared error of positions [rad²]"),
}


def residual_error(
    cells: "pd.DataFrame", losses: Sequence["pd.DataFrame"], grid: Grid, gains: str
) -> Figure:
    """What is left over the grid, in positions and as S*, and beside it how the search got there.

    Args:
        cells: one row a cell, columns `CELL_COLUMNS`.
        losses: for each cell, its loss by iteration.
        gains: `free` or `known`, see `SEARCHES`.
    """
    with styled():
        figure, axes = plt.subplots(1, 3, figsize=(1.5 * width(grid), height(grid) + 0.6))
        _map(axes[0], 1e3 * np.sqrt(matrix(cells, "mse_rad2", grid)), grid, "positions, RMS [mrad]")
        if cells.s_star.notna().any():
            label = "S* [rad² + (rad/s)²]"
            _map(axes[1], matrix(cells, "s_star", grid), grid, label)
        else:
            axes[1].set_axis_off()
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
            axes[2].semilogy(table.iteration + 1, table.loss, **style)
        axes[2].set_xlabel(SEARCHES[gains][0])
        axes[2].set_ylabel(SEARCHES[gains][1])
        axes[2].legend(fontsize=7)
        figure.suptitle("Identified training simulators", fontsize=11)
    return figure


def _map(axes: Axes, values: np.ndarray, grid: Grid, label: str) -> None:
    heatmap(
        axes,
        *(values, grid, "magma_r", error_norm(values.flat)),
        text=lambda value: f"{value:.2g}",
        label=label,
        region="SO",
    )


def over_true(table: "pd.DataFrame") -> Figure:
    """Identified over true values: a panel a parameter, a row a joint, a column a cell.

    Args:
        table: columns `t2l.stats.identification.COLUMNS`.
    """
    with styled():
        names = list(dict.fromkeys(table.parameter))
        joints = short(list(dict.fromkeys(table.joint)))
        cells = list(dict.fromkeys(zip(table.kp, table.kd, strict=True)))
        columns, numbered = (len(names) + 1) // 2, len(cells) <= NUMBERED
        figure, axes = plt.subplots(
            *(2, columns),
            figsize=(
                1.2 + (0.42 if numbered else 0.12) * len(cells) * columns,
                2.2 + 0.5 * len(joints),
            ),
            sharex=True, sharey=True, squeeze=False,
        )  # fmt: skip
        for panel in axes.flat[len(names) :]:
            panel.set_axis_off()
        for panel, name in zip(axes.flat, names, strict=False):
            part = table[table.parameter == name]
            ratio = part.pivot_table("ratio", "joint", ["kp", "kd"], sort=False)
            values = ratio.reindex(list(joints))[cells].to_numpy()
            image = panel.imshow(
                np.log2(np.maximum(values, 2.0**-6)), cmap="RdBu_r", vmin=-2, vmax=2, aspect="auto"
            )
            for (row, column), value in np.ndenumerate(values) if numbered else ():
                text = f"{value:.2g}".removeprefix("0") if value < 100 else "≥100"
                panel.text(column, row, text, ha="center", va="center", fontsize=5)
            panel.set_title(name, fontsize=8)
            panel.set_yticks(range(len(joints)), list(joints.values()), fontsize=7)
            labels = [f"{plain(kp)}, {plain(kd)}" for kp, kd in cells]
            panel.set_xticks(range(len(cells)), labels, rotation=90, fontsize=6 if numbered else 5)
            panel.spines[:].set_visible(False)
        for panel in axes[-1]:
            panel.set_xlabel("cell Kp, Kd", fontsize=8)
        bar = figure.colorbar(image, ax=axes, shrink=0.7, label="identified over true")
        bar.set_ticks([-2, -1, 0, 1, 2], labels=["≤ ¼", "½", "1", "2", "≥ 4"])
        figure.suptitle("Identified over true", fontsize=11)
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
