"""The error over pairs of gains."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.diagnose.results import Compared, mapped, same_gains
from t2l.figures.diagnosis.panels import BLACK, colours, place, placed_by_hand
from t2l.gains import Grid
from t2l.plotting.heatmap import error_norm, heatmap
from t2l.plotting.style import plain_ticks, shown, styled

MOST_NUMBERS = 25  # in a joint's panel of cells; more take long to draw and are hard to read


def error_by_cell(compared: Sequence[Compared]) -> Figure:
    """RMS error by gains: all joints together and each joint; of two models one above the other.

    Where no joint had more than one pair of gains, the error by joint.
    """
    if not mapped(compared[0]):
        return _by_joint(compared)
    joints: list[str | None] = list(compared[0].traces.joints)
    alike = same_gains(compared[0])
    if alike and len(joints) > 1:
        joints = [None, *joints]
    floor = compared[0].numbers["noise_floor_rad"]
    errors = [1e3 * c["rmse_q_rad"] for one in compared for c in one.numbers["cells"]]
    norm = error_norm(errors, floor and 1e3 * floor)
    grids = {joint: _grid(compared[0], joint) for joint in joints}
    columns = len(joints) if len(joints) <= 4 else (len(joints) + 1) // 2
    per_model = -(-len(joints) // columns)
    rows = per_model * len(compared)
    width = 0.3 * max(4, max(len(g.kp) for g in grids.values())) + (0.15 if alike else 0.55)
    height = 0.24 * max(4, max(len(g.kd) for g in grids.values())) + (0.35 if alike else 0.6)
    size = (width * columns + 1.7, height * rows + 0.7)
    with styled(), placed_by_hand():
        figure, axes = plt.subplots(
            *(rows, columns), figsize=size, squeeze=False, sharex=alike, sharey=alike
        )
        space = {"wspace": 0.08, "hspace": 0.22} if alike else {"wspace": 0.3, "hspace": 0.45}
        place(figure, left=0.65, right=1.05, bottom=0.5, top=0.3, **space)
        for panel in axes.flat:
            panel.set_axis_off()
        for row, one in enumerate(compared):
            for i, joint in enumerate(joints):
                panel = axes[row * per_model + i // columns, i % columns]
                panel.set_axis_on()
                values = _matrix(one, joint, grids[joint])
                numbered = joint is None or values.size <= MOST_NUMBERS
                heatmap(
                    *(panel, values, grids[joint], "magma_r", norm),
                    text=(lambda value: f"{value:.2g}") if numbered else (lambda value: ""),
                    label=None,
                )
                for text in panel.texts:
                    text.set_fontsize(6)
                panel.tick_params(labelsize=7, length=2)
                panel.set(xlabel="", ylabel="")
                name = shown(joint) if joint else "all joints"
                panel.set_title(
                    name if len(compared) == 1 else f"{name}, {one.label}", fontsize=7, pad=2
                )
        figure.supxlabel("stiffness Kp [N·m/rad]", fontsize=8, y=0.08 / size[1])
        figure.supylabel("damping Kd [N·m·s/rad]", fontsize=8, x=0.08 / size[0])
        beside = figure.add_axes((1 - 0.85 / size[0], 0.5 / size[1], 0.12 / size[0], 0.75))
        bar = figure.colorbar(plt.cm.ScalarMappable(norm, "magma_r"), cax=beside)
        bar.set_label("RMS position error [mrad]", fontsize=8)
        plain_ticks(bar.ax.yaxis)
        bar.ax.tick_params(labelsize=7)
        bar.outline.set_visible(False)
    return figure


def _by_joint(compared: Sequence[Compared]) -> Figure:
    """RMS error of each joint, the largest above: a map over gains would be one cell."""
    numbers = [one.numbers["joints"] for one in compared]
    joints = sorted(numbers[0], key=lambda joint: numbers[0][joint]["rmse_q_rad"])
    floor = compared[0].numbers["noise_floor_rad"]
    with styled():
        figure, axes = plt.subplots(figsize=(6.0, 1.2 + 0.22 * len(compared) * len(joints)))
        high = 0.8 / len(compared)
        for i, (one, colour) in enumerate(zip(compared, colours(compared), strict=True)):
            errors = [1e3 * one.numbers["joints"][joint]["rmse_q_rad"] for joint in joints]
            at = np.arange(len(joints)) + high * ((len(compared) - 1) / 2 - i)
            bars = axes.barh(at, errors, 0.9 * high, color=colour, label=one.label)
            axes.bar_label(bars, [f"{error:.3g}" for error in errors], padding=3, fontsize=7)
        if floor:
            text = f"noise floor, {1e3 * floor:.2g} mrad"
            axes.axvline(1e3 * floor, color=BLACK, ls="--", lw=1, label=text)
        axes.set_yticks(range(len(joints)), [shown(joint) for joint in joints], fontsize=8)
        axes.margins(x=0.12)
        axes.set_xlim(left=0)
        axes.set_xlabel("RMS position error [mrad], with one pair of gains")
        axes.legend(fontsize=8)
    return figure


def _grid(compared: Compared, joint: str | None) -> Grid:
    own = [c for c in compared.numbers["cells"] if c["joint"] == joint]
    kp, kd = (tuple(sorted({c[key] for c in own})) for key in ("kp", "kd"))
    # no region is outlined: the recordings say nothing of one
    return Grid(kp, kd, compliant_up_to_kp=-np.inf, overdamped_from_kd=np.inf)


def _matrix(compared: Compared, joint: str | None, grid: Grid) -> np.ndarray:
    values = np.full((len(grid.kd), len(grid.kp)), np.nan)
    for cell in compared.numbers["cells"]:
        if cell["joint"] == joint:
            at = grid.kd.index(cell["kd"]), grid.kp.index(cell["kp"])
            values[at] = 1e3 * cell["rmse_q_rad"]
    return values
