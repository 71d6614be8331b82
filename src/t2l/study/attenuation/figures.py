"""What controllers leave of errors of commands: theory, success, replays under noise."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from t2l.advise.attenuation import SMALL
from t2l.gains import Cell, Grid
from t2l.plotting.heatmap import heatmap, height, matrix, width
from t2l.plotting.over_time import panels_over_time
from t2l.plotting.style import COLOURS, plain_ticks, styled, title
from t2l.stats.text import interval
from t2l.study.published.numbers import REGIONS

if TYPE_CHECKING:
    import pandas as pd

_COLOURS = dict(zip(REGIONS, COLOURS, strict=False))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_LABELS = {
    "effective_error": "effective error √(h Kp/(2 Kd)) ε",
    "loss": "validation error ε²",
    "damping_over_stiffness": "Kd / Kp [s]",
}


def variance(held: "pd.DataFrame", grid: Grid) -> Figure:
    """Simulated variance against the theorem's, and their ratio beside what is exact.

    Args:
        held: one row a plant and cell, see `rack.held_noise`.
    """
    with styled():
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9))
        table = held.assign(
            regions=_regions(held, grid),
            x=held.theorem_rad2 / held.noise_rad**2,
            y=held.variance_rad2 / held.noise_rad**2,
            error=1.96 * held.variance_rad2_se / held.noise_rad**2,
            exact=held.exact_rad2 / held.theorem_rad2,
            continuous=held.continuous_rad2 / held.theorem_rad2,
        )
        plants = dict(zip(table.plant.unique(), _MARKERS, strict=False))
        for (plant, region), own in table.groupby(["plant", "regions"]):
            style = {
                "fmt": plants[plant], "color": _COLOURS[region], "ms": 4.5, "lw": 0.8, "mfc": "none"
            }  # fmt: skip
            left.errorbar(own.x, own.y, own.error, **style)
            right.errorbar(own.x, own.y / own.x, own.error / own.x, **style)
        for _, line in table.sort_values("kp").groupby(["plant", "kd"]):
            right.plot(line.x, line.exact, color="0.7", lw=0.7, zorder=0)
            right.plot(line.x, line.continuous, color="0.7", lw=0.7, ls=":", zorder=0)
        ends = np.array([table.x.min() / 2, table.x.max() * 2])
        left.plot(ends, ends, color="black", lw=0.8)
        right.axhline(1, color="black", lw=0.8)
        right.axvspan(ends[0], SMALL, color="0.95", zorder=-1)
        left.set_ylabel("simulated Var[δq] / σ²")
        right.set_ylabel("simulated / theorem")
        left.set_yscale("log")
        right.set_ylim(0, max(1.5, 1.05 * float((table.y / table.x).max())))
        for axes in (left, right):
            axes.set_xscale("log")
            axes.set_xlim(*ends)
            axes.set_xlabel("theorem: h Kp / (2 Kd)")
        regions = [_dot(colour) for colour in _COLOURS.values()]
        kinds = [_dot("0.3", marker) for marker in plants.values()]
        figure.legend(
            *([*regions, *kinds, *(Line2D([], [], color="0.7", ls=line) for line in "-:")],),
            [*_COLOURS, *plants, "exact, timestep of 2 ms", "exact, continuous"],
            loc="outside lower center", ncols=5, fontsize=8,
        )  # fmt: skip
        figure.suptitle(
            "Noise on the commanded position: what the controller leaves of it", fontsize=11
        )
    return figure


def success(
    grids: Mapping[str, "pd.DataFrame"], correlations: "pd.DataFrame", grid: Grid
) -> Figure:
    """A row a grid of cells: success over what could tell it, with Spearman's ρ.

    Args:
        grids: by name, one row a cell, see `success.predictors`.
        correlations: see `statistics.effective_error_table`.
        grid: whose bounds say which region a cell is in.
    """
    known = correlations.set_index(["grid", "predictor"])
    with styled():
        figure, axes = plt.subplots(
            *(len(grids), len(_LABELS)),
            figsize=(9, 0.9 + 2.1 * len(grids)),
            sharex="col" if len(grids) == 1 else False,
            sharey="row",
            squeeze=False,
        )
        for row, (name, cells) in enumerate(grids.items()):
            colours = [_COLOURS[region] for region in _regions(cells, grid)]
            for panel, (column, label) in zip(axes[row], _LABELS.items(), strict=True):
                panel.scatter(cells[column], 100 * cells.success, c=colours, s=16, lw=0)
                panel.set_xscale("log")
                plain_ticks(panel.xaxis)
                one = known.loc[(name, column)]
                text = interval(one.rho, one.low, one.high)
                panel.set_title(f"ρ {text}", fontsize=8, loc="right")
                if row == len(grids) - 1:
                    panel.set_xlabel(label)
            axes[row, 0].set_ylabel(f"{title(name)}\nsuccess [%]", fontsize=8)
        figure.legend(
            *([_dot(colour) for colour in _COLOURS.values()], list(_COLOURS)),
            loc="outside lower center", ncols=4, fontsize=8,
        )  # fmt: skip
        figure.suptitle("What tells the success of a cloned policy", fontsize=11)
    return figure


def noise_success(
    replays: "pd.DataFrame", undisturbed: "pd.DataFrame", grid: Grid, heading: str
) -> Figure:
    """Success of open-loop replays: without noise, with the same in every cell, with its own.

    Args:
        replays: one row a replay, see `noise.COLUMNS`.
        undisturbed: one row a cell, kp, kd and replay_success.
    """
    by_cell = replays.groupby(["condition", "kp", "kd"], as_index=False).success.mean()
    count = int(replays.groupby(["condition", "kp", "kd"]).size().max())
    largest = replays[replays.condition == "same"].magnitude_rad.max()
    panels = {
        "without noise": undisturbed.groupby(["kp", "kd"], as_index=False).agg(
            success=("replay_success", "mean")
        ),
        f"up to {1000 * largest:.2g} mrad in every cell": by_cell[by_cell.condition == "same"],
        "up to each cell's own error": by_cell[by_cell.condition == "own"],
    }
    with styled():
        figure, axes = plt.subplots(
            1, 3, figsize=(1.45 * width(grid), height(grid) + 0.3), sharey=True
        )
        for panel, (label, table) in zip(axes, panels.items(), strict=True):
            values = matrix(table, "success", grid)
            heatmap(
                panel, values, grid, "viridis", Normalize(0, 1),
                text=lambda v: f"{100 * v:.0f}", label=None,
            )  # fmt: skip
            region = panel.get_title(loc="left")
            panel.set_title(f"{label}\n{region}", fontsize=8, loc="left", parse_math=True)
            if panel is not axes[0]:
                panel.set_ylabel("")
        bar = figure.colorbar(axes[-1].images[0], ax=axes, label=f"success [% of {count}]")
        bar.set_ticks([0, 0.25, 0.5, 0.75, 1], labels=["0", "25", "50", "75", "100"])
        bar.outline.set_visible(False)
        figure.suptitle(f"{heading}: demonstrations replayed under noise", fontsize=11)
    return figure


def noise_traces(
    traces: Mapping[Cell, "pd.DataFrame"], shown: Mapping[str, str], grid: Grid, heading: str
) -> Figure:
    """One column a cell, one row a joint: a demonstration undisturbed, and under noise.

    Args:
        traces: see `noise.traces`.
        shown: label and column of the joints to show.
    """
    with styled():
        columns = [f"{grid.region(cell)}: {cell}" for cell in traces]
        rows = [f"{label} [rad]" for label in shown]
        figure, axes = panels_over_time(rows, columns, 3.6, 1.6)
        for column, table in zip(axes.T, traces.values(), strict=True):
            for panel, name in zip(column, shown.values(), strict=True):
                _lines(panel, table, name)
        figure.legend(
            [Line2D([], [], color="black"), Line2D([], [], color=COLOURS[1])],
            ["without noise", "with noise on every command"],
            loc="outside lower center", ncols=2,
        )  # fmt: skip
        figure.suptitle(f"{heading}: the same commands under the same noise", fontsize=11)
    return figure


def _lines(axes: Axes, table: "pd.DataFrame", name: str) -> None:
    for (condition, _), own in table.groupby(["condition", "replay"]):
        noisy = condition != "none"
        style = {"color": COLOURS[1], "lw": 0.7, "alpha": 0.7} if noisy else {"color": "black"}
        axes.plot(own.time_s, own[name], zorder=1 if noisy else 2, **style)


def _regions(table: "pd.DataFrame", grid: Grid) -> list[str]:
    return [grid.region(Cell(kp, kd)) for kp, kd in zip(table.kp, table.kd, strict=True)]


def _dot(colour: str, marker: str = "o") -> Line2D:
    return Line2D([], [], ls="", marker=marker, color=colour, ms=5)
