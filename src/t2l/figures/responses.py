"""What a robot does when it is commanded, at the corners of the grid (the study's figure 2)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.gains import Cell, Grid
from t2l.plotting.style import COLOURS, short, styled

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("joint", "time", "q_des", "q")


def responses(motions: Mapping[str, Mapping[Cell, "pd.DataFrame"]], grid: Grid) -> Figure:
    """A column a cell, a row a motion and joint: commanded and measured position.

    Args:
        motions: by what they are, for each cell, a row a sample and joint, columns `COLUMNS`, rad
            from home.
    """
    with styled():
        cells = list(next(iter(motions.values())))
        rows = [
            (motion, joint)
            for motion, tables in motions.items()
            for joint in dict.fromkeys(next(iter(tables.values())).joint)
        ]
        labels = short(list(dict.fromkeys(joint for _, joint in rows)))
        figure, axes = plt.subplots(
            *(len(rows), len(cells)),
            figsize=(2.3 * len(cells) + 0.8, 1.35 * len(rows) + 0.9),
            sharex="row", sharey="row", squeeze=False,
        )  # fmt: skip
        for row, (motion, joint) in enumerate(rows):
            for column, cell in enumerate(cells):
                table, panel = motions[motion][cell], axes[row, column]
                part = table[table.joint == joint]
                panel.step(
                    part.time, part.q_des, where="post", color="0.6", lw=0.9, label="commanded"
                )
                panel.plot(part.time, part.q, color=COLOURS[0], lw=1.3, label="measured")
            axes[row, 0].set_ylabel(f"{motion}\n{labels[joint]} [rad]", fontsize=8)
            for panel in axes[row]:
                panel.set_xlabel("time [s]" if row == len(rows) - 1 else "")
        for panel, cell in zip(axes[0], cells, strict=True):
            panel.set_title(f"{grid.region(cell)}: {cell}", fontsize=9)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.align_ylabels()
        figure.suptitle("Responses to commands", fontsize=11)
    return figure
