"""The error over frequency."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.diagnose import traces as of_traces
from t2l.diagnose.results import Compared, noise_density
from t2l.figures.diagnosis.panels import BLACK, colours, place, placed_by_hand
from t2l.plotting.style import plain_ticks, shown, styled


def spectrum(compared: Sequence[Compared]) -> Figure:
    """Amplitude density of the error: each joint of one model, or all joints of two."""
    traces = compared[0].traces
    joints = range(len(traces.joints))
    with styled(), placed_by_hand():
        figure, axes = plt.subplots(figsize=(6.0, 3.4))
        place(figure, left=0.75, right=0.15, bottom=0.5, top=0.15)
        if len(compared) == 1:
            for joint in joints:
                frequency, density = of_traces.spectrum(traces, joint)
                axes.loglog(frequency, 1e3 * density, lw=1.2, label=shown(traces.joints[joint]))
        else:
            for one, colour in zip(compared, colours(compared), strict=True):
                of_joints = [of_traces.spectrum(one.traces, joint) for joint in joints]
                # joints sampled alike share their frequencies; otherwise the first speaks
                same = [d for f, d in of_joints if len(f) == len(of_joints[0][0])]
                density = np.sqrt(np.mean(np.square(same), axis=0))
                axes.loglog(of_joints[0][0], 1e3 * density, color=colour, label=one.label)
        noise = noise_density(compared[0])
        if noise:
            axes.axhline(noise, color=BLACK, ls="--", lw=1, label="noise floor")
        plain_ticks(axes.xaxis, axes.yaxis)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("position error [mrad/√Hz]")
        axes.legend(fontsize=8, ncols=2)
    return figure
