"""Commanded and achieved joint positions."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from t2l.gains import Cell
from t2l.plotting.over_time import panels_over_time
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
        figure, axes = panels_over_time(list(shown), [str(cell) for cell in episodes], 2.4, 1.7)
        for column, (command, achieved) in zip(axes.T, episodes.values(), strict=True):
            time = np.arange(len(command)) / rate_hz
            for panel, joint in zip(column, shown.values(), strict=True):
                panel.step(
                    *(time, command[:, joint]),
                    where="post",
                    color=COLOURS[1],
                    lw=0.9,
                    label="commanded",
                )
                panel.plot(time, achieved[:, joint], color=COLOURS[0], lw=1.3, label="achieved")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.suptitle(title, fontsize=11)
    return figure
