"""Which effect of the robot makes policies shake, cell by cell."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.gains import Cell
from t2l.plotting.style import styled

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("effect", "kp", "kd", "jitter_rate")


def ablation(cells: "pd.DataFrame", inside: dict[Cell, bool]) -> Figure:
    """A row an effect that is left out, a column a cell: share of rollouts that jitter.

    Args:
        cells: columns `COLUMNS`, the whole robot first.
        inside: of each cell whether it is stiff and overdamped; those are drawn first.
    """
    effects = list(dict.fromkeys(cells.effect))
    order = sorted(inside, key=lambda cell: (not inside[cell], cell))
    shares = cells.pivot(index="effect", columns=["kp", "kd"], values="jitter_rate")
    values = np.array([[shares.loc[e, (cell.kp, cell.kd)] for cell in order] for e in effects])
    with styled():
        figure, panel = plt.subplots(
            # its title is as wide as five cells
            figsize=(0.62 * max(len(order), 5) + 3.2, 0.34 * len(effects) + 1.9),
            layout="constrained",
        )
        image = panel.imshow(100 * values, cmap="magma_r", vmin=0, vmax=100, aspect="auto")
        for (row, column), value in np.ndenumerate(values):
            colour = "white" if value > 0.6 else "black"
            panel.text(
                column,
                row,
                f"{100 * value:.0f}",
                ha="center",
                va="center",
                color=colour,
                fontsize=8,
            )
        names = [f"without {e.replace('_', ' ')}" if i else e for i, e in enumerate(effects)]
        panel.set_yticks(range(len(effects)), names, fontsize=8)
        labels = [f"{cell.kp:g}\n{cell.kd:g}" for cell in order]
        panel.set_xticks(range(len(order)), labels, fontsize=8)
        panel.set_xlabel("Kp [N·m/rad]\nKd [N·m·s/rad]")
        stiff = sum(inside.values())
        if 0 < stiff < len(order):
            panel.axvline(stiff - 0.5, color="0.2", ls="--", lw=1)
            panel.set_title("left of the line: stiff, overdamped cells", fontsize=9)
        figure.colorbar(image, ax=panel, label="jitter to their end [%]")
        figure.suptitle("The same policies on the robot without one of its effects", fontsize=11)
    return figure
