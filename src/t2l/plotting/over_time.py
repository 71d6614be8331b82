"""Panels of signals over time: a row a signal, a column a case."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure


def panels_over_time(
    rows: Sequence[str], columns: Sequence[str], width: float, height: float
) -> tuple[Figure, np.ndarray]:
    """A figure and its (nrow, ncolumn) axes, which share time, and in a row the signal's range.

    Args:
        rows: labels of signals, with units, at the left.
        columns: titles on top.
        width, height: of a panel, inches.
    """
    figure, axes = plt.subplots(
        *(len(rows), len(columns)),
        figsize=(width * len(columns) + 0.8, height * len(rows) + 0.9),
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    for panel, label in zip(axes[:, 0], rows, strict=True):
        panel.set_ylabel(label)
    for top, bottom, heading in zip(axes[0], axes[-1], columns, strict=True):
        top.set_title(heading)
        bottom.set_xlabel("time [s]")
    return figure, axes
