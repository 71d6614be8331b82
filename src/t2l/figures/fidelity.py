"""Retargeting fidelity against the rate of the position commands."""

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from t2l.gains import Cell
from t2l.plotting.style import COLOURS, styled

COLUMNS = ("kp", "kd", "hold", "decimation", "success", "mse_q_rad2")

# the study's validation: at least 90 % success and an MSE below 1e-3 rad² up to 25×
SUCCESS_BOUND = 0.9
MSE_BOUND_RAD2 = 1e-3
DECIMATION_BOUND = 25
_LINES = {"mean": ("-", "mean over the hold"), "sample": (":", "sampled at its start")}


def fidelity(table: pd.DataFrame, simulation_rate_hz: float, title: str) -> Figure:
    """Replay success and joint position error against decimation, a line per cell and hold.

    Args:
        table: one row per replay, columns `COLUMNS`.
    """
    summary = table.groupby(["hold", "kp", "kd", "decimation"], as_index=False).agg(
        success=("success", "mean"), mse=("mse_q_rad2", "mean"), replays=("success", "size")
    )
    cells = sorted({Cell(kp, kd) for kp, kd in zip(summary.kp, summary.kd, strict=True)})
    with styled():
        figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6))
        for colour, cell in zip(COLOURS, cells, strict=False):
            for hold, (line, _) in _LINES.items():
                rows = summary[
                    (summary.kp == cell.kp) & (summary.kd == cell.kd) & (summary.hold == hold)
                ]
                style = {"color": colour, "ls": line, "marker": "o", "ms": 3}
                left.plot(rows.decimation, 100 * rows.success, **style)
                right.plot(rows.decimation, rows.mse, **style)
        left.axhline(100 * SUCCESS_BOUND, color="0.6", lw=0.8)
        right.axhline(MSE_BOUND_RAD2, color="0.6", lw=0.8)
        for axes in (left, right):
            axes.axvline(DECIMATION_BOUND, color="0.6", lw=0.8)
            axes.set_xlabel(f"decimation of {simulation_rate_hz:g} Hz commands")
        left.set_ylabel(f"replay success [% of {int(summary.replays.max())}]")
        left.set_ylim(-3, 103)
        right.set_ylabel("joint position MSE [rad²]")
        right.set_yscale("log")
        colours = [plt.Line2D([], [], color=c) for c, _ in zip(COLOURS, cells, strict=False)]
        lines = [plt.Line2D([], [], color="0.3", ls=line) for line, _ in _LINES.values()]
        figure.legend(
            [*colours, *lines],
            [*map(str, cells), *(f"command {name}" for _, name in _LINES.values())],
            loc="outside lower center",
            ncols=3,
            fontsize=8,
        )
        figure.suptitle(title, fontsize=11)
    return figure
