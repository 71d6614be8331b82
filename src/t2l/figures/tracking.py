"""Commanded and achieved joint positions."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.gains import Cell
from t2l.plotting.style import COLOURS, styled


def tracking(
    episodes: Mapping[Cell, tuple[np.ndarray, np.ndarray]],
    shown: Mapping[str, int],
    rate_hz: float,
    title: str,
) -> Figure:
    """One column per cell, one row per element of a command: as it was held, and as achieved.

    Args:
        episodes: per cell, commands of one replay, and what they are about, (n, ncommand) each.
        shown: label and index of the elements to show, rad or m.
        rate_hz: rate of the rows.
    """
    with styled():
        figure, axes = plt.subplots(
            *(len(shown), len(episodes)),
            figsize=(2.4 * len(episodes) + 0.8, 1.7 * len(shown) + 0.9),
            sharex=True,
            sharey="row",
            squeeze=False,
        )
        for column, (cell, (command, achieved)) in enumerate(episodes.items()):
            time = np.arange(len(command)) / rate_hz
            for row, (label, joint) in enumerate(shown.items()):
                panel = axes[row, column]
                panel.step(
                    *(time, command[:, joint]),
                    where="post",
                    color=COLOURS[1],
                    lw=0.9,
                    label="commanded",
                )
                panel.plot(time, achieved[:, joint], color=COLOURS[0], lw=1.3, label="achieved")
                if column == 0:
                    panel.set_ylabel(label)
            axes[0, column].set_title(str(cell))
            axes[-1, column].set_xlabel("time [s]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.suptitle(title, fontsize=11)
    return figure
