"""Advice over the grid of gains: what is left, how the loop answers, what cloning is told."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from t2l.advise.advice import Advice
from t2l.advise.exclusions import KINDS
from t2l.plotting.heatmap import error_norm, heatmap, height, width
from t2l.plotting.style import styled

LONGEST_LAG_S = 10.0  # format: where colours end


def advice_maps(advice: Advice) -> Figure:
    """One map a panel, rows by Kd upward, columns by Kp; crossed cells are ruled out."""
    panels = _panels(advice)
    grid = advice.asked.grid
    rows = -(-len(panels) // 2)
    with styled():
        figure, axes = plt.subplots(
            rows, 2, figsize=(1.2 * width(grid), rows * (height(grid) + 0.2)), squeeze=False
        )
        for panel in axes.flat[len(panels) :]:
            panel.set_visible(False)
        for panel, (title, values, colours, norm, text, label) in zip(
            axes.flat, panels, strict=False
        ):
            shown = np.where(np.isfinite(values), values, np.nan).reshape(len(grid.kd), -1)
            heatmap(panel, shown, grid, colours, norm, text, label, region=None)
            panel.set_title(title, fontsize=9, loc="left")
            _mark(panel, advice)
    return figure


def _panels(advice: Advice) -> list[tuple]:
    found, cloning = advice.responses, advice.cloning
    over = np.minimum(found.overshoot.max(axis=1), 1.0)
    margin, lag = found.margin.min(axis=1), found.lag_s.max(axis=1)
    lags = np.clip(lag, 1e-3, LONGEST_LAG_S)
    loop = [
        (
            "how far a step is passed, worst joint", 100 * over, "magma_r", Normalize(0, 100),
            "{:.0f}".format, "overshoot [%]",
        ),
        (
            "times that gains may rise, worst joint", margin, "viridis", LogNorm(1, 16, clip=True),
            "{:.1f}".format, "margin",
        ),
        (
            "how far the arm is behind a ramp, slowest joint", 1e3 * lags, "cividis",
            LogNorm(*_ends(1e3 * lags)), "{:.0f}".format, "lag [ms]",
        ),
    ]  # fmt: skip
    if cloning is None:
        return [*loop, *_room(advice)]
    error = 1e3 * cloning.error
    replay = 1e3 * cloning.replay.rmse_rad.max(axis=1)
    lead = 1e3 * cloning.labels.lead_rad.max(axis=1)
    return [
        (
            "predicted error of a cloned policy", error, "magma_r", error_norm(_finite(error)),
            "{:.3g}".format, "predicted error [mrad]",
        ),
        *loop,
        (
            "how far commands run ahead, RMS, farthest joint", lead, "cividis",
            LogNorm(*_ends(lead)), "{:.0f}".format, "lead [mrad]",
        ),
        (
            "error of replayed demonstrations, worst joint", replay, "magma_r",
            error_norm(_finite(replay)), "{:.2g}".format, "RMS error [mrad]",
        ),
        *_room(advice),
    ]  # fmt: skip


def _room(advice: Advice) -> list[tuple]:
    if advice.scales is None:
        return []
    room = advice.scales.room
    if not np.isfinite(room).any():
        return []
    norm = LogNorm(0.1, 10, clip=True)
    title = "room of action scales within torque limits, worst joint"
    return [(title, room, "viridis", norm, "{:.2g}".format, "largest / least action scale")]


def _finite(values: np.ndarray) -> list[float]:
    return values[np.isfinite(values)].tolist()


def _ends(values: np.ndarray) -> tuple[float, float]:
    known = values[np.isfinite(values) & (values > 0)]
    low, high = (known.min(), known.max()) if len(known) else (1.0, 2.0)
    return low, max(high, 1.01 * low)


def _mark(axes: Axes, advice: Advice) -> None:
    columns = len(advice.asked.grid.kp)
    ruled = advice.ruled_out
    for i in range(len(ruled)):
        row, column = divmod(i, columns)
        if ruled[i]:
            for ends in ((-0.5, 0.5), (0.5, -0.5)):
                axes.plot(
                    [column - 0.5, column + 0.5], [row + ends[0], row + ends[1]],
                    color="0.5", lw=0.6,
                )  # fmt: skip
        if advice.as_good[i] or i == advice.best:
            line = 2.4 if i == advice.best else 1.0
            axes.add_patch(
                Rectangle(
                    (column - 0.46, row - 0.46), 0.92, 0.92, fill=False, ec="#009E73", lw=line
                )
            )
    axes.set_xlim(-0.5, columns - 0.5)
    axes.set_ylim(-0.5, len(advice.asked.grid.kd) - 0.5)


def reasons(advice: Advice) -> Figure:
    """Of every joint, what it has against which gains."""
    grid, joints = advice.asked.grid, advice.asked.joints
    columns = min(4, len(joints))
    rows = -(-len(joints) // columns)
    colours = plt.get_cmap("tab10")(np.arange(len(KINDS)))
    with styled():
        figure, axes = plt.subplots(
            rows, columns, figsize=(2.6 * columns + 1.6, 2.4 * rows + 0.4), squeeze=False,
            sharex=True, sharey=True,
        )  # fmt: skip
        for panel in axes.flat[len(joints) :]:
            panel.set_visible(False)
        for j, panel in enumerate(axes.flat[: len(joints)]):
            image = np.ones((len(grid.cells), 4))
            for one in advice.objections:
                if one.joint == j:
                    image[one.cell] = colours[KINDS.index(one.kind)]
            panel.imshow(image.reshape(len(grid.kd), -1, 4), origin="lower", aspect="auto")
            panel.set_xticks(range(len(grid.kp)), [f"{kp:g}" for kp in grid.kp], fontsize=6)
            panel.set_yticks(range(len(grid.kd)), [f"{kd:g}" for kd in grid.kd], fontsize=6)
            panel.set_title(joints[j], fontsize=8)
        used = sorted({one.kind for one in advice.objections}, key=KINDS.index)
        handles = [Rectangle((0, 0), 1, 1, color=colours[KINDS.index(kind)]) for kind in used]
        if handles:
            figure.legend(handles, used, loc="outside right upper", fontsize=8)
        figure.supxlabel("stiffness Kp [N·m/rad]", fontsize=8)
        figure.supylabel("damping Kd [N·m·s/rad]", fontsize=8)
    return figure
