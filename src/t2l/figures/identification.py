"""What identification leaves: error over the grid, and measured against simulated motion."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from t2l.gains import Cell, Grid
from t2l.plotting.heatmap import error_norm, heatmap, height, matrix, width
from t2l.plotting.style import COLOURS, plain, short, styled

if TYPE_CHECKING:
    import pandas as pd

CELL_COLUMNS = ("kp", "kd", "mse_rad2", "s_star", "loss", "on_bound")
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
    """Identified over true values: a row a parameter, a column a joint, in each a map over gains.

    Of a single cell one map, a row a parameter and a column a joint, with its numbers.

    Args:
        table: columns `t2l.stats.identification.COLUMNS`.
    """
    names = list(dict.fromkeys(table.parameter))
    joints = short(list(dict.fromkeys(table.joint)))
    kp, kd = (sorted(table[key].unique()) for key in ("kp", "kd"))
    by = table.set_index(["parameter", "joint", "kd", "kp"]).ratio.to_dict()
    ratios = np.array(
        [[[[by.get((n, j, d, p), np.nan) for p in kp] for d in kd] for j in joints] for n in names]
    )
    with styled():
        if ratios[0, 0].size == 1:
            figure, image = _one_cell(ratios[..., 0, 0], names, list(joints.values()))
        else:
            figure, image = _maps(ratios, names, list(joints.values()), kp, kd)
        bar = figure.colorbar(image, ax=figure.axes, shrink=0.6, aspect=30, pad=0.01)
        bar.set_ticks([-2, -1, 0, 1, 2], labels=["≤ ¼", "½", "1", "2", "≥ 4"])
        bar.set_label("identified over true")
        bar.outline.set_visible(False)
    return figure


# of a ratio: white is right, a factor of four either way has full colour
_RATIO = {"cmap": "RdBu_r", "vmin": -2, "vmax": 2, "aspect": "auto"}


def _ratio(values: np.ndarray) -> np.ndarray:
    """Powers of two, so that half and double are as far from one."""
    return np.log2(np.maximum(values, 2.0**-6))


def _one_cell(
    ratios: np.ndarray, names: Sequence[str], joints: Sequence[str]
) -> tuple[Figure, AxesImage]:
    """(nparameter, njoint) with their numbers."""
    size = (2.4 + 0.75 * len(joints), 1.2 + 0.36 * len(names))
    figure, panel = plt.subplots(figsize=size)
    image = panel.imshow(_ratio(ratios), **_RATIO)
    for (row, column), value in np.ndenumerate(ratios):
        text = "–" if np.isnan(value) else f"{value:.2g}" if value < 100 else "≥ 100"
        light = 0.25 < value < 4 or np.isnan(value)
        colour = "black" if light else "white"
        panel.text(column, row, text, ha="center", va="center", fontsize=8, color=colour)
    panel.set_xticks(range(len(joints)), joints)
    panel.set_yticks(range(len(names)), names)
    panel.spines[:].set_visible(False)
    return figure, image


def _maps(
    ratios: np.ndarray,
    names: Sequence[str],
    joints: Sequence[str],
    kp: Sequence[float],
    kd: Sequence[float],
) -> tuple[Figure, AxesImage]:
    """(nparameter, njoint, nkd, nkp): small maps whose axes are written once."""
    shape = ratios.shape[:2]
    size = (1.9 + 1.0 * shape[1], 0.9 + 1.0 * shape[0])
    figure, axes = plt.subplots(*shape, figsize=size, sharex=True, sharey=True, squeeze=False)
    for (row, column), panel in np.ndenumerate(axes):
        image = panel.imshow(_ratio(ratios[row, column]), origin="lower", **_RATIO)
        panel.set_xticks(_some(kp), [plain(kp[i]) for i in _some(kp)], fontsize=8)
        panel.set_yticks(_some(kd), [plain(kd[i]) for i in _some(kd)], fontsize=8)
        panel.spines[:].set_color("0.8")
        panel.spines[:].set_visible(True)
        panel.tick_params(length=2, color="0.6")
        if row == 0:
            panel.set_title(joints[column], fontsize=9)
        if column == 0:
            panel.set_ylabel(names[row].replace(" ", "\n"), fontsize=9)
    figure.supxlabel("in each map, to the right: stiffness Kp [N·m/rad]", fontsize=9)
    figure.supylabel("in each map, upward: damping Kd [N·m·s/rad]", fontsize=9)
    return figure, image


def _some(gains: Sequence[float]) -> list[int]:
    """The first, the middle and the last: more would touch one another below so small a map."""
    return sorted({0, (len(gains) - 1) // 2, len(gains) - 1})


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
