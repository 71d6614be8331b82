"""Commanded, measured and simulated motion."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from t2l.diagnose.results import Compared
from t2l.diagnose.traces import Traces
from t2l.figures.diagnosis.panels import (
    BLACK,
    GREY,
    colours,
    joints_by_error,
    place,
    placed_by_hand,
)
from t2l.plotting.style import shown, styled

MOST_JOINTS = 4  # more rows do not fit a page


def overlays(compared: Sequence[Compared]) -> Figure:
    """Commanded, measured and simulated position in the worst, median and best recording.

    A row a joint; of more than `MOST_JOINTS`, those with the largest errors.
    """
    traces = compared[0].traces
    chosen = representative(traces)
    joints = sorted(joints_by_error(traces)[:MOST_JOINTS])
    size = (2.6 * len(chosen) + 1.0, 1.3 * len(joints) + 1.1)
    with styled(), placed_by_hand():
        figure, axes = plt.subplots(
            *(len(joints), len(chosen)), figsize=size, sharex="col", squeeze=False
        )
        place(figure, left=0.75, right=0.1, bottom=0.45, top=0.65, wspace=0.22, hspace=0.2)
        for column, (label, recording) in enumerate(chosen):
            axes[0, column].set_title(f"{label}: {shown(traces.recordings[recording])}", fontsize=8)
            axes[-1, column].set_xlabel("time [s]")
            for row, joint in enumerate(joints):
                panel = axes[row, column]
                _overlay(panel, compared, recording, joint)
                if column == 0:
                    panel.set_ylabel(f"{shown(traces.joints[joint])} [rad]", fontsize=8)
                panel.tick_params(labelsize=7)
                panel.yaxis.set_major_locator(MaxNLocator(4))
                panel.xaxis.set_major_locator(MaxNLocator(4))
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="upper center", ncols=len(labels), fontsize=8)
    return figure


def _overlay(panel: Axes, compared: Sequence[Compared], recording: int, joint: int) -> None:
    traces = compared[0].traces
    at = traces.at(recording, joint)
    time = traces.columns["time"][at]
    panel.step(
        *(time, traces.columns["q_des"][at]), where="post", color=GREY, lw=0.7, label="commanded"
    )
    panel.plot(time, traces.columns["q"][at], color=BLACK, lw=1.3, label="measured")
    for one, colour in zip(compared, colours(compared), strict=True):
        panel.plot(time, one.traces.columns["q_sim"][at], color=colour, lw=1.1, label=one.label)


def representative(traces: Traces) -> list[tuple[str, int]]:
    """The worst, the median and the best recording by RMS error, as far as they differ."""
    count = len(traces.recordings)
    squares = np.bincount(traces.recording, traces.error**2, count)
    order = np.argsort(squares / np.maximum(np.bincount(traces.recording, minlength=count), 1))
    chosen = {int(order[-1]): "worst", int(order[0]): "best"}
    chosen.setdefault(int(order[count // 2]), "median")
    names = {"worst": 0, "median": 1, "best": 2}
    return sorted(((label, i) for i, label in chosen.items()), key=lambda entry: names[entry[0]])
