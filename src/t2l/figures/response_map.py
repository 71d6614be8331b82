"""Where joints lie in natural frequency and damping ratio, and in which of the four regions."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from t2l.plotting.style import COLOURS, plain_ticks, short, shown, styled
from t2l.response.joints import JointResponse

TOGETHER = 24  # points that can be told apart in one panel; of more, each joint has its own
COLUMNS = 4
MARKERS = ("o", "s", "^", "D")  # beside colours, for more joints than there are colours
MOST_HZ, MOST_ZETA = 500.0, 300.0  # shown: faster or more damped than any controller of a robot
CORNERS = {"CO": (0.03, 0.97), "SO": (0.97, 0.97), "CU": (0.03, 0.03), "SU": (0.97, 0.03)}


def response_map(found: Sequence[JointResponse], stiff_from_hz: float) -> Figure:
    """ω_n over ζ of every joint with 95 % intervals, and the four regions.

    A point is filled if its region is certain. What the motion does not tell is counted.
    """
    joints = list(dict.fromkeys(response.joint for response in found))
    groups = [[r for r in found if r.joint == joint] for joint in joints]
    with styled():
        if len(found) <= TOGETHER or len(joints) == 1:
            figure = _together(groups, stiff_from_hz)
        else:
            figure = _apart(groups, short(joints), stiff_from_hz)
        hollow = {"ls": "", "marker": "o", "color": "0.4", "mfc": "white"}
        marks = [
            Line2D([], [], ls="", marker="o", color="0.4", label="region certain at 95 %"),
            Line2D([], [], **hollow, label="uncertain"),
        ]
        figure.legend(handles=marks, loc="outside upper center", ncols=2, fontsize=8)
        figure.supxlabel("natural frequency ω_n / 2π [Hz]", fontsize=9)
        figure.supylabel("damping ratio ζ", fontsize=9)
    return figure


def _together(groups: Sequence[Sequence[JointResponse]], stiff_from_hz: float) -> Figure:
    """All joints in one panel, told apart by colours."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    for number, members in enumerate(groups):
        colour = COLOURS[number % len(COLOURS)]
        marker = MARKERS[number // len(COLOURS) % len(MARKERS)]
        _points(axes, members, colour, marker)
        name = f"{shown(members[0].joint)}{_untold(members)}"
        axes.plot([], [], ls="", marker=marker, color=colour, label=name)
    _frame(axes, [r for members in groups for r in members], stiff_from_hz)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside right upper", fontsize=8, title="joint"
    )
    return figure


def _apart(
    groups: Sequence[Sequence[JointResponse]], names: dict[str, str], stiff_from_hz: float
) -> Figure:
    """A panel a joint, all with the same axes."""
    columns = min(COLUMNS, len(groups))
    rows = -(-len(groups) // columns)
    figure, panels = plt.subplots(
        rows, columns, figsize=(2.5 * columns + 0.4, 2.3 * rows + 0.7),
        sharex=True, sharey=True, squeeze=False,
    )  # fmt: skip
    everything = [r for members in groups for r in members]
    for axes, members in zip(panels.flat, groups, strict=False):
        _points(axes, members, COLOURS[0], "o")
        _frame(axes, everything, stiff_from_hz)
        axes.set_title(f"{names[members[0].joint]}{_untold(members)}", fontsize=9)
    for axes in panels.flat[len(groups) :]:
        axes.set_axis_off()
    for column in range(columns):
        last = panels[(len(groups) - 1 - column) // columns, column]
        last.tick_params(labelbottom=True)
    return figure


def _points(axes: Axes, members: Sequence[JointResponse], colour: str, marker: str) -> None:
    for response in members:
        if not _told(response):
            continue
        fit = response.fit
        x, y = fit.omega / (2 * np.pi), fit.zeta
        across, along = np.array(fit.interval(0)) / (2 * np.pi), fit.interval(1)
        bars = {"color": colour, "lw": 0.7, "alpha": 0.35, "zorder": 2}
        axes.plot(across, (y, y), **bars)
        axes.plot((x, x), along, **bars)
        fill = colour if response.region.certain else "white"
        axes.plot(x, y, marker, ms=4, color=colour, mfc=fill, mew=0.9, zorder=3)


def _frame(axes: Axes, found: Sequence[JointResponse], stiff_from_hz: float) -> None:
    """Axes that hold all points, and the regions, whose names no point hides."""
    fits = [r.fit for r in found if _told(r)] or [r.fit for r in found]
    hz = np.array([fit.omega for fit in fits]) / (2 * np.pi)
    zeta = np.array([fit.zeta for fit in fits])
    axes.set(xscale="log", yscale="log")
    axes.set_xlim(min(hz.min(), stiff_from_hz) / 2, min(max(hz.max(), stiff_from_hz) * 2, MOST_HZ))
    axes.set_ylim(min(zeta.min() / 2, 0.5), min(max(zeta.max() * 2, 2.0), MOST_ZETA))
    plain_ticks(axes.xaxis, axes.yaxis)
    axes.axhline(1.0, color="0.6", lw=0.8, zorder=1)
    axes.axvline(stiff_from_hz, color="0.6", lw=0.8, zorder=1)
    for text, (x, y) in CORNERS.items():
        axes.text(
            x, y, text, transform=axes.transAxes, color="0.25", fontsize=9, zorder=5,
            ha="left" if x < 0.5 else "right", va="bottom" if y < 0.5 else "top",
            path_effects=[withStroke(linewidth=3, foreground="white")],
        )  # fmt: skip


def _told(response: JointResponse) -> bool:
    return bool(np.isfinite(response.fit.covariance).all())


def _untold(members: Sequence[JointResponse]) -> str:
    count = sum(not _told(r) for r in members)
    return f" ({count} of {len(members)} not told)" if count else ""
