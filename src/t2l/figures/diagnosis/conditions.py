"""The torque that a model lacks, over what it may depend on."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.diagnose.conditions import LABELS, UNITS
from t2l.diagnose.results import Compared
from t2l.diagnose.traces import binned
from t2l.figures.diagnosis.panels import GREY, colours, joints_by_error, place, placed_by_hand
from t2l.plotting.style import COLOURS, shown, styled

PANELS = ("velocity", "acceleration", "torque", "gravity", "position", "time")


def residual_by_condition(compared: Sequence[Compared]) -> Figure:
    """Mean missing torque over the conditions.

    Of one model all joints are drawn; of two, the joint with the largest error at first.
    """
    traces = compared[0].traces
    joints = range(len(traces.joints)) if len(compared) == 1 else joints_by_error(traces)[:1]
    with styled(), placed_by_hand():
        figure, axes = plt.subplots(2, 3, figsize=(8.4, 4.8), sharey=True)
        place(figure, left=0.8, right=0.1, bottom=0.45, top=0.6, wspace=0.08, hspace=0.35)
        for panel, condition in zip(axes.flat, PANELS, strict=True):
            for one, colour in zip(compared, colours(compared), strict=True):
                for joint in joints:
                    at = np.flatnonzero(one.traces.joint == joint)
                    x = one.traces.columns[condition][at]
                    means = binned(x, one.traces.columns["missing_torque"][at])
                    panel.plot(
                        *means,
                        **{"marker": ".", "ms": 4, "lw": 1.3},
                        color=COLOURS[joint % len(COLOURS)] if len(compared) == 1 else colour,
                        label=shown(traces.joints[joint]) if len(compared) == 1 else one.label,
                    )
            panel.axhline(0, color=GREY, lw=0.6, zorder=0)
            unit, label = UNITS[condition], LABELS.get(condition, condition)
            panel.set_xlabel(f"{label} [{unit}]" if unit else label)
        for panel in axes[:, 0]:
            panel.set_ylabel("missing torque [N·m]")
        handles, labels = axes.flat[0].get_legend_handles_labels()
        if len(compared) == 2:
            labels = [f"{shown(traces.joints[joints[0]])}, {label}" for label in labels]
        figure.legend(handles, labels, loc="upper center", ncols=min(len(labels), 7), fontsize=8)
    return figure
