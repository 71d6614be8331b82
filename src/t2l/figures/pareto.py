"""The trials of a search of gains: what each comes to, and which of them none beats."""

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.artefacts import write_text
from t2l.plotting.style import plain_ticks, styled, write

if TYPE_CHECKING:
    import pandas as pd

# what an axis says of each objective
LABELS = {
    "effort": "effort: torque over its limit, RMS",
    "jitter_rad_s": "jitter [rad/s]",
    "transfer_error": "error of transfer, E",
}
KINDS = (
    ("breaks a limit", {"marker": "x", "s": 22, "lw": 0.9}),
    ("allowed", {"marker": "o", "s": 26, "ec": "0.4", "lw": 0.5}),
    ("in the front", {"marker": "o", "s": 62, "ec": "k", "lw": 1.4}),
)


def pareto(trials: "pd.DataFrame") -> Figure:
    """The gains of all trials, and their success over each other objective; colour is Kp.

    Args:
        trials: see `t2l.rl.gain_search.table`; those of the front bear their numbers.
    """
    from matplotlib.colors import LogNorm

    known = trials.dropna(subset=["success"])
    costs = [name for name in LABELS if name in known]
    panels = [("kp", "kd"), *((name, "success") for name in costs)]
    norm = LogNorm(trials.kp.min() * 0.99, trials.kp.max() * 1.01)
    kind = known.feasible.astype(int) + known.front
    with styled():
        figure, axes = plt.subplots(1, len(panels), figsize=(3.1 * len(panels) + 0.8, 3.4))
        for panel, (across, upward) in zip(axes, panels, strict=True):
            for number, (label, style) in enumerate(KINDS):
                part = known[kind == number]
                shown = panel.scatter(
                    part[across], part[upward] * (100 if upward == "success" else 1),
                    c=part.kp, cmap="viridis", norm=norm, label=label, **style,
                )  # fmt: skip
            for row in known[known.front].to_dict("records"):
                panel.annotate(
                    str(row["number"]),
                    (row[across], row[upward] * (100 if upward == "success" else 1)),
                    xytext=(6, 4), textcoords="offset points", fontsize=7,
                )  # fmt: skip
            panel.set_xscale("log")
            if upward == "success":
                panel.set_ylim(-5, 112)
                panel.set_xlabel(LABELS[across])
                panel.set_ylabel("success in simulation [%]")
            else:
                panel.set_yscale("log")
                panel.set_xlabel("Kp")
                panel.set_ylabel("Kd")
                plain_ticks(panel.yaxis)
            plain_ticks(panel.xaxis)
        bar = figure.colorbar(shown, ax=axes.tolist(), label="Kp")
        plain_ticks(bar.ax.yaxis)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    return figure


def write_search(trials: "pd.DataFrame", folder: Path) -> None:
    """Write trials.csv, front.csv and figures/front of a search's table."""
    write_text(trials.to_csv(index=False), folder / "trials.csv")
    write_text(trials[trials.front].to_csv(index=False), folder / "front.csv")
    write(pareto(trials), [folder / "figures" / f"front.{kind}" for kind in ("pdf", "png")])
