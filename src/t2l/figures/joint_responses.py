"""How joints follow their commands: motion, second-order fit and frequency response."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from t2l.plotting.style import COLOURS, shown, styled
from t2l.response.joints import JointResponse

SHOWN_S = 6.0  # of the first motion
MOST = 12  # rows; the map holds all
WIDER = 1.5  # times the highest measured frequency: where the fitted response is drawn to


def response_motions(found: Sequence[JointResponse]) -> Figure:
    """Command, motion and fit of some joints, spread over all, and their frequency responses."""
    places = np.linspace(0, len(found) - 1, min(MOST, len(found))).round().astype(int)
    chosen = [found[place] for place in places]
    with styled():
        figure, rows = plt.subplots(
            *(len(chosen), 2), figsize=(8.0, 1.7 * len(chosen) + 0.6), squeeze=False,
            width_ratios=(2, 1),
        )  # fmt: skip
        for (left, right), response in zip(rows, chosen, strict=True):
            _motion(left, response)
            _frequencies(right, response)
        rows[-1, 0].set_xlabel("time [s]")
        rows[-1, 1].set_xlabel("frequency [Hz]")
        handles, labels = rows[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, fontsize=8)
        figure.align_ylabels(rows[:, 0])
    return figure


def _motion(axes: Axes, response: JointResponse) -> None:
    time, command, q = response.rows[0]
    held, measured = time <= SHOWN_S, np.isfinite(q)
    axes.step(time[held], command[held], where="post", color="0.6", label="command")
    at = held & measured
    axes.plot(time[at], q[at], ".", ms=3, color=COLOURS[0], label="motion")
    axes.plot(
        time[measured][held[measured]], response.fit.predicted[0][held[measured]],
        color=COLOURS[1], lw=1.0, label="second order",
    )  # fmt: skip
    axes.set_title(f"{shown(response.label)}, {shown(response.joint)}", fontsize=8)
    axes.set_ylabel(f"position\n[{response.unit}]", fontsize=8)


def _frequencies(axes: Axes, response: JointResponse) -> None:
    """Gain as measured, and that of the fit."""
    measured = response.frequencies
    if measured is None:
        axes.set_axis_off()
        return
    error = 1.96 * measured.gain_error
    axes.errorbar(measured.hz, measured.gain, yerr=error, fmt=".", color=COLOURS[0])
    hz = np.linspace(0.0, WIDER * measured.hz[-1], 200)
    s = 2j * np.pi * hz / response.fit.omega
    gain = np.abs(response.fit.gain / (s**2 + 2 * response.fit.zeta * s + 1))
    axes.plot(hz, gain, color=COLOURS[1], lw=1.0)
    axes.set_xlim(0.0, hz[-1])
    axes.set_ylim(0.0, 1.2 * max(1.0, measured.gain.max(), gain.max()))
    axes.set_ylabel("gain", fontsize=8)
