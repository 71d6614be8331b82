"""Where a model fails, as figures; each shows one model, or two: as it came and final."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from t2l.diagnose import traces as of_traces
from t2l.diagnose.conditions import UNITS
from t2l.diagnose.traces import Traces, binned
from t2l.figures.heatmap import heatmap
from t2l.figures.style import COLOURS, shown, styled, write
from t2l.gains import Grid
from t2l.report.artefacts import Compared, read_found
from t2l.report.payload import noise_density, same_gains, titles_of

BLUE, ORANGE, SKY, BLACK = COLOURS[0], COLOURS[1], COLOURS[5], COLOURS[6]
GREY = "#8a939d"
FORMATS = ("png", "pdf")
MOST_JOINTS = 4  # of which the overlays are drawn
MOST_NUMBERS = 25  # in a joint's panel of cells
PANELS = ("velocity", "acceleration", "torque", "gravity", "position", "time")
LEAST_SHOWN = -0.4  # improvements below are drawn at the edge


def draw_comparison(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l compare` found."""
    _draw(Path(folder), _of_comparison(read_found(folder).compared))


def draw_diagnosis(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l diagnose` found."""
    _draw(Path(folder), {"ranking": ranking(read_found(folder).steps[0].diagnosis)})


def draw_explanation(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l explain` found."""
    found = read_found(folder)
    steps, floor = (found.explanation[key] for key in ("steps", "noise_floor_rad"))
    figures = {"error_falling": error_falling(steps, floor, titles_of(found))}
    figures |= {
        f"ranking_{number}": ranking(step.diagnosis)
        for number, step in enumerate(found.steps, start=1)
        if step.diagnosis["ranking"]
    }
    _draw(Path(folder), figures | _of_comparison(found.compared))


def _draw(folder: Path, figures: Mapping[str, Figure]) -> None:
    for name, figure in figures.items():
        write(figure, [folder / "figures" / f"{name}.{suffix}" for suffix in FORMATS])


def _of_comparison(compared: Sequence[Compared]) -> dict[str, Figure]:
    if not compared:
        return {}
    return {
        "overlays": overlays(compared),
        "error_by_cell": error_by_cell(compared),
        "residual_by_condition": residual_by_condition(compared),
        "spectrum": spectrum(compared),
    }


def _placed_by_hand():
    # the automatic layout takes seconds for many panels
    return plt.rc_context({"figure.constrained_layout.use": False})


def _place(figure: Figure, left, right, bottom, top, wspace=None, hspace=None) -> None:
    """Leave these margins in inches, and these parts of a panel between panels."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(
        left / width, bottom / height, 1 - right / width, 1 - top / height, wspace, hspace
    )


def _by_error(traces: Traces) -> list[int]:
    """Joints, the one with the largest squared error first."""
    squares = np.bincount(traces.joint, traces.error**2, len(traces.joints))
    return np.argsort(-squares).tolist()


def _colours(compared: Sequence[Compared]) -> tuple[str, ...]:
    return (BLUE,) if len(compared) == 1 else (ORANGE, BLUE)


def overlays(compared: Sequence[Compared]) -> Figure:
    """Commanded, measured and simulated position in the worst, median and best recording.

    A row a joint; of more than `MOST_JOINTS`, those with the largest errors.
    """
    traces = compared[0].traces
    chosen = representative(traces)
    joints = sorted(_by_error(traces)[:MOST_JOINTS])
    size = (2.6 * len(chosen) + 1.0, 1.3 * len(joints) + 1.1)
    with styled(), _placed_by_hand():
        figure, axes = plt.subplots(
            *(len(joints), len(chosen)), figsize=size, sharex="col", squeeze=False
        )
        _place(figure, left=0.75, right=0.1, bottom=0.45, top=0.65, wspace=0.22, hspace=0.2)
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
    for one, colour in zip(compared, _colours(compared), strict=True):
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


def error_by_cell(compared: Sequence[Compared]) -> Figure:
    """RMS error by gains: all joints together and each joint; of two models one above the other."""
    joints: list[str | None] = list(compared[0].traces.joints)
    alike = same_gains(compared[0])
    if alike and len(joints) > 1:
        joints = [None, *joints]
    norm = _norm([1e3 * c["rmse_q_rad"] for one in compared for c in one.numbers["cells"]])
    grids = {joint: _grid(compared[0], joint) for joint in joints}
    columns = len(joints) if len(joints) <= 4 else (len(joints) + 1) // 2
    per_model = -(-len(joints) // columns)
    rows = per_model * len(compared)
    width = 0.3 * max(4, max(len(g.kp) for g in grids.values())) + (0.15 if alike else 0.55)
    height = 0.24 * max(4, max(len(g.kd) for g in grids.values())) + (0.35 if alike else 0.6)
    size = (width * columns + 1.7, height * rows + 0.7)
    with styled(), _placed_by_hand():
        figure, axes = plt.subplots(
            *(rows, columns), figsize=size, squeeze=False, sharex=alike, sharey=alike
        )
        space = {"wspace": 0.08, "hspace": 0.22} if alike else {"wspace": 0.3, "hspace": 0.45}
        _place(figure, left=0.65, right=1.05, bottom=0.5, top=0.3, **space)
        for panel in axes.flat:
            panel.set_axis_off()
        for row, one in enumerate(compared):
            for i, joint in enumerate(joints):
                panel = axes[row * per_model + i // columns, i % columns]
                panel.set_axis_on()
                values = _matrix(one, joint, grids[joint])
                # many numbers take long to draw and are hard to read
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
        place = figure.add_axes((1 - 0.85 / size[0], 0.5 / size[1], 0.12 / size[0], 0.75))
        bar = figure.colorbar(plt.cm.ScalarMappable(norm, "magma_r"), cax=place)
        bar.set_label("RMS position error [mrad]", fontsize=8)
        _plain_ticks(bar.ax.yaxis)
        bar.ax.tick_params(labelsize=7)
        bar.outline.set_visible(False)
    return figure


def _norm(values: Sequence[float]) -> LogNorm:
    known = [value for value in values if value > 0] or [1.0]
    return LogNorm(min(known), max(max(known), 1.01 * min(known)))


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


def residual_by_condition(compared: Sequence[Compared]) -> Figure:
    """Mean missing torque over the conditions.

    Of one model all joints are drawn; of two, the joint with the largest error at first.
    """
    traces = compared[0].traces
    joints = range(len(traces.joints)) if len(compared) == 1 else _by_error(traces)[:1]
    with styled(), _placed_by_hand():
        figure, axes = plt.subplots(2, 3, figsize=(8.4, 4.8), sharey=True)
        _place(figure, left=0.8, right=0.1, bottom=0.45, top=0.6, wspace=0.08, hspace=0.35)
        for panel, condition in zip(axes.flat, PANELS, strict=True):
            for one, colour in zip(compared, _colours(compared), strict=True):
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
            unit = UNITS[condition]
            panel.set_xlabel(f"{condition} [{unit}]" if unit else condition)
        for panel in axes[:, 0]:
            panel.set_ylabel("missing torque [N·m]")
        handles, labels = axes.flat[0].get_legend_handles_labels()
        if len(compared) == 2:
            labels = [f"{shown(traces.joints[joints[0]])}, {label}" for label in labels]
        figure.legend(handles, labels, loc="upper center", ncols=min(len(labels), 7), fontsize=8)
    return figure


def spectrum(compared: Sequence[Compared]) -> Figure:
    """Amplitude density of the error: each joint of one model, or all joints of two."""
    traces = compared[0].traces
    joints = range(len(traces.joints))
    with styled(), _placed_by_hand():
        figure, axes = plt.subplots(figsize=(6.0, 3.4))
        _place(figure, left=0.75, right=0.15, bottom=0.5, top=0.15)
        if len(compared) == 1:
            for joint in joints:
                frequency, density = of_traces.spectrum(traces, joint)
                axes.loglog(frequency, 1e3 * density, lw=1.2, label=shown(traces.joints[joint]))
        else:
            for one, colour in zip(compared, _colours(compared), strict=True):
                of_joints = [of_traces.spectrum(one.traces, joint) for joint in joints]
                # joints sampled alike share their frequencies; otherwise the first speaks
                same = [d for f, d in of_joints if len(f) == len(of_joints[0][0])]
                density = np.sqrt(np.mean(np.square(same), axis=0))
                axes.loglog(of_joints[0][0], 1e3 * density, color=colour, label=one.label)
        noise = noise_density(compared[0])
        if noise:
            axes.axhline(noise, color=BLACK, ls="--", lw=1, label="noise floor")
        _plain_ticks(axes.xaxis, axes.yaxis)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("position error [mrad/√Hz]")
        axes.legend(fontsize=8, ncols=2)
    return figure


def error_falling(
    steps: Sequence[Mapping[str, Any]], floor: float, titles: Mapping[str, str] | None = None
) -> Figure:
    """Training and held-out RMS error after every added effect, and the noise floor.

    Args:
        steps: of explanation.json: `effect` (None at first), `train_rmse_q_rad`,
            `heldout_rmse_q_rad`.
        floor: rad, the error of a perfect model.
        titles: what to print for an effect.
    """
    names = [(titles or {}).get(step["effect"], step["effect"]) for step in steps]
    labels = ["model as\nit came", *(fill(f"+ {shown(name)}", 16) for name in names[1:])]
    at = np.arange(len(steps))
    with styled():
        figure, axes = plt.subplots(figsize=(max(4.2, 1.4 * len(steps) + 1.2), 3.4))
        for key, style, colour, label in (
            ("heldout_rmse_q_rad", "o-", BLUE, "held out"),
            ("train_rmse_q_rad", "o:", SKY, "training"),
        ):
            axes.plot(at, [1e3 * s[key] for s in steps], style, color=colour, lw=2, label=label)
        text = f"noise floor, {1e3 * floor:.2g} mrad"
        axes.axhline(1e3 * floor, color=BLACK, ls="--", lw=1, label=text)
        axes.set_yscale("log")
        _plain_ticks(axes.yaxis)
        axes.set_xticks(at, labels)
        axes.set_xlim(-0.4, len(steps) - 0.6)
        axes.set_ylabel("RMS position error [mrad]")
        axes.legend()
    return figure


def _plain_ticks(*axes: Axis) -> None:
    """Label logarithmic axes 0.1, 1, 10; between them 2 and 5 where decades are few."""
    for axis in axes:
        low, high = axis.get_view_interval()
        few = high < 100 * low
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if few else (1,)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def ranking(diagnosis: Mapping[str, Any]) -> Figure:
    """Fall of the held-out error with each effect, with 95 % intervals, best above.

    Args:
        diagnosis: content of diagnosis.json.
    """
    entries = list(diagnosis["ranking"])
    first = entries[0] if entries and diagnosis["verdict"] == "missing_effect" else None
    with styled():
        figure, axes = plt.subplots(figsize=(6.2, 1.0 + 0.21 * max(len(entries), 3)))
        for row, entry in enumerate(entries):
            improvement = np.array(
                [*entry["improvement"]["ci95"], entry["improvement"]["fraction"]]
            )
            low, high, value = 100 * np.maximum(improvement, LEAST_SHOWN)
            colour = GREY
            if first is not None and entry is first:
                colour = BLUE
            elif first is not None and entry["effect"] in first["tied_with"]:
                colour = COLOURS[4]
            axes.plot([low, high], [row, row], color=colour, lw=1.6)
            axes.plot(value, row, "<" if improvement[2] < LEAST_SHOWN else "o", color=colour, ms=5)
        axes.axvline(0, color=GREY, lw=0.6, zorder=0)
        axes.set_yticks(
            range(len(entries)), [shown(entry["title"]) for entry in entries], fontsize=8
        )
        axes.invert_yaxis()
        axes.set_xlim(right=102)
        axes.set_xlabel("fall of the held-out error [%], with 95 % interval")
    return figure
