"""The effects that were tried and added, and by how much each lowers the error."""

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from t2l.diagnose.results import kind_of
from t2l.figures.diagnosis.panels import BLACK, BLUE, GREY, SKY
from t2l.plotting.style import COLOURS, plain_ticks, shown, styled

# of a ranking: what a mark means, its colour, and that of its inside if another
KINDS = {
    "best": ("ranked first", BLUE, None),
    "tied": ("explains as well", COLOURS[4], None),
    "linear": ("linear model only", GREY, "white"),
    "other": ("other", GREY, None),
}
LEAST_SHOWN = -0.4  # improvements below are drawn at the edge
WIDTH, MOST_LINES = 16, 10  # format: of the name of a step, in characters and lines


def error_falling(steps: Sequence[tuple[str, float | None, float]], floor: float) -> Figure:
    """Training and test RMS error after every step, and the noise floor.

    Args:
        steps: label, training and test error in rad, see `t2l.diagnose.results.errors_by_step`.
        floor: rad, the error of a perfect model.
    """
    labels = [_wrapped(label) for label, _, _ in steps]
    at = np.arange(len(steps))
    with styled():
        figure, axes = plt.subplots(figsize=(max(4.2, 1.4 * len(steps) + 1.2), 3.4))
        for column, style, colour, label in ((2, "o-", BLUE, "test"), (1, "o:", SKY, "training")):
            errors = [1e3 * step[column] for step in steps if step[column] is not None]
            axes.plot(at[: len(errors)], errors, style, color=colour, lw=2, label=label)
        text = f"noise floor, {1e3 * floor:.2g} mrad"
        axes.axhline(1e3 * floor, color=BLACK, ls="--", lw=1, label=text)
        axes.set_yscale("log")
        plain_ticks(axes.yaxis)
        axes.set_xticks(at, labels)
        axes.set_xlim(-0.4, len(steps) - 0.6)
        axes.set_ylabel("RMS position error [mrad]")
        axes.legend()
    return figure


def _wrapped(label: str) -> str:
    lines = [shown(line) for line in wrap(label, WIDTH)]
    return "\n".join(lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], "…"])


def ranking(diagnosis: Mapping[str, Any]) -> Figure:
    """Fall of the error on what is left out of the fit, with 95 % intervals, the largest above.

    Args:
        diagnosis: content of diagnosis.json.
    """
    entries = sorted(diagnosis["ranking"], key=lambda entry: -entry["improvement"]["fraction"])
    marks = {}
    with styled():
        figure, axes = plt.subplots(figsize=(6.2, 1.0 + 0.21 * max(len(entries), 3)))
        for row, entry in enumerate(entries):
            improvement = np.array(
                [*entry["improvement"]["ci95"], entry["improvement"]["fraction"]]
            )
            low, high, value = 100 * np.maximum(improvement, LEAST_SHOWN)
            what, colour, face = KINDS[kind_of(entry, diagnosis)]
            axes.plot([low, high], [row, row], color=colour, lw=1.6, zorder=1)
            off = improvement[2] < LEAST_SHOWN
            style = {"marker": "<" if off else "o", "ms": 5, "ls": "none"}
            mark = axes.plot(value, row, color=colour, mfc=face or colour, **style)[0]
            marks.setdefault("worse than the axis" if off else what, mark)
        if set(marks) - {"other"}:
            figure.legend(
                marks.values(), marks.keys(), loc="outside upper center", ncols=4, fontsize=7
            )
        axes.axvline(0, color=GREY, lw=0.6, zorder=0)
        axes.set_yticks(
            range(len(entries)), [shown(entry["title"]) for entry in entries], fontsize=8
        )
        axes.invert_yaxis()
        axes.set_xlim(right=102)
        axes.set_xlabel("fall of the error on what is left out [%], with 95 % interval")
    return figure
