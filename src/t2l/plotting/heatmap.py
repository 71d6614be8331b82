"""Heatmaps over a grid of cells: Kp to the right, Kd upward."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Rectangle

from t2l.gains import Grid
from t2l.plotting.style import plain

if TYPE_CHECKING:
    import pandas as pd

LEAST_SPAN = 10.0  # format: of a colour scale of errors: a decade, as on a logarithmic axis


def error_limits(values: Iterable[float], floor: float | None = None) -> tuple[float, float]:
    """Where the colours of errors begin and end on a logarithmic scale, so that they mean a size.

    They begin at the noise floor, if it is known, and span `LEAST_SPAN` at least: errors that
    differ by little have colours that differ by little.

    Args:
        values: errors; what is not above zero counts as none.
        floor: an error that is noise, in the same unit.
    """
    known = [float(value) for value in values if value > 0]
    high = max(known, default=floor or 1.0)
    if floor:
        return floor, max(high, LEAST_SPAN * floor)
    return min(min(known, default=high), high / LEAST_SPAN), high


def error_norm(values: Iterable[float], floor: float | None = None) -> LogNorm:
    """The colour scale of `error_limits`; what lies outside has the colour of its end."""
    return LogNorm(*error_limits(values, floor), clip=True)


def matrix(table: "pd.DataFrame", column: str, grid: Grid) -> np.ndarray:
    """A column as (nkd, nkp): the mean over a cell's rows, NaN where it has none."""
    by_cell = table.groupby(["kp", "kd"])[column].mean()
    values = [[by_cell.get((kp, kd), np.nan) for kp in grid.kp] for kd in grid.kd]
    return np.array(values, dtype=float)


def heatmap(
    axes: Axes,
    values: np.ndarray,
    grid: Grid,
    colours: str,
    norm: Normalize,
    text: Callable[[float], str],
    label: str | None,
    percent: bool = False,
    region: str | None = "CO",
) -> None:
    """Draw values (nkd, nkp) with their text, blank where NaN; with a label, a colour bar too.

    A single cell has nothing to be compared with: its number is written, and no map is drawn.

    Args:
        region: to outline, as `Grid.region` names it: of the overdamped ones; or none.
    """
    if values.size == 1:
        axes.set_axis_off()
        value = "nothing" if np.isnan(values.item()) else text(values.item())
        said = [label] if label else []
        said += [value, f"at Kp {plain(grid.kp[0])}, Kd {plain(grid.kd[0])}"]
        middle = {"ha": "center", "va": "center", "transform": axes.transAxes}
        axes.text(0.5, 0.5, "\n".join(said), fontsize=9, **middle)
        return
    image = axes.imshow(values, origin="lower", cmap=colours, norm=norm, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        if np.isnan(value):
            continue
        red, green, blue, _ = image.cmap(image.norm(value))
        light = 0.299 * red + 0.587 * green + 0.114 * blue > 0.5
        axes.text(
            *(column, row, text(value)),
            ha="center",
            va="center",
            color="black" if light else "white",
            fontsize=8,
        )
    axes.set_xticks(range(len(grid.kp)), [plain(kp) for kp in grid.kp])
    axes.set_yticks(range(len(grid.kd)), [plain(kd) for kd in grid.kd])
    axes.set_xlabel("stiffness Kp [N·m/rad]")
    axes.set_ylabel("damping Kd [N·m·s/rad]")
    axes.spines[:].set_visible(False)
    if region is not None:
        _outline(axes, grid, region)
    if label is None:
        return
    bar = axes.figure.colorbar(image, ax=axes, label=label, shrink=0.9)
    bar.outline.set_visible(False)
    if percent:
        bar.set_ticks([0, 0.25, 0.5, 0.75, 1], labels=["0", "25", "50", "75", "100"])


def _outline(axes: Axes, grid: Grid, region: str) -> None:
    compliant = sum(kp <= grid.compliant_up_to_kp for kp in grid.kp)
    left, width = (0, compliant) if region == "CO" else (compliant, len(grid.kp) - compliant)
    underdamped = sum(kd < grid.overdamped_from_kd for kd in grid.kd)
    height = len(grid.kd) - underdamped
    if not width or not height:
        return
    corner = (left - 0.5, underdamped - 0.5)
    for colour, line, dashes in (("white", 2.5, "-"), ("black", 1.2, "--")):
        axes.add_patch(
            Rectangle(
                corner, width, height, fill=False, ec=colour, lw=line, ls=dashes, clip_on=False
            )
        )
    word = "compliant" if region == "CO" else "stiff"
    text = f"dashed: {word}, overdamped region $G^{{{region}}}$"
    axes.set_title(text, fontsize=8, loc="left", parse_math=True)


def width(grid: Grid) -> float:
    """Inches for two heatmaps side by side."""
    return 3.4 + 1.1 * max(4, len(grid.kp))


def height(grid: Grid) -> float:
    """Inches for a heatmap."""
    return 1.4 + 0.42 * max(4, len(grid.kd))
