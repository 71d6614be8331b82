"""What advice lost in worlds whose best gains are known, and how sure it may be."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from t2l.plotting.style import COLOURS, styled

if TYPE_CHECKING:
    import pandas as pd

HALVES: Mapping[str, tuple[str, str]] = {
    "development": ("none", "development"), "test": ("full", "test"),
}  # fmt: skip


def planted_worlds(losses: "pd.DataFrame", reliability: "pd.DataFrame", within: float) -> Figure:
    """Left: a dot a world and rule. Right: pairs in the right order, by the chance stated.

    Args:
        losses: of `t2l.stats.planted.losses`, rules in the order to show.
        reliability: of `t2l.stats.planted.reliability`, of what one kind of advice knows.
        within: what counts as no loss.
    """
    with styled():
        figure, (left, right) = plt.subplots(
            1, 2, figsize=(9.4, 3.6), gridspec_kw={"width_ratios": [1.5, 1]}
        )
        _losses(left, losses, within)
        _reliability(right, reliability)
    return figure


def _losses(axes: Axes, table: "pd.DataFrame", within: float) -> None:
    rules = list(dict.fromkeys(table.rule))
    for row, rule in enumerate(reversed(rules)):
        for shift, (half, (fill, _)) in zip((0.15, -0.15), HALVES.items(), strict=True):
            own = 100 * table[(table.rule == rule) & (table.half == half)].lost.to_numpy()
            at = np.full(len(own), row + shift)
            axes.plot(own, at, "o", ms=4, fillstyle=fill, color=COLOURS[0], alpha=0.8)
    axes.axvline(0, color="black", lw=0.6)
    axes.axvline(100 * within, color="black", lw=0.8, ls="--")
    axes.set_yticks(range(len(rules)), rules[::-1])
    axes.set_ylim(-0.6, len(rules) - 0.4)
    axes.set_xlabel("success less than the best cell's, per cent points")
    axes.grid(axis="x", lw=0.4)


def _reliability(axes: Axes, table: "pd.DataFrame") -> None:
    axes.plot([50, 100], [50, 100], color="black", lw=0.6)
    for shift, (half, (fill, name)) in zip((-0.4, 0.4), HALVES.items(), strict=True):
        own = table[table.half == half]
        share = 100 * own.right.to_numpy()
        ends = 100 * own[["low", "high"]].to_numpy().T
        axes.errorbar(
            100 * own.stated + shift, share, yerr=np.abs(np.nan_to_num(ends - share)),
            fmt="o", ms=5, lw=1.2, fillstyle=fill, color=COLOURS[0], label=name,
        )  # fmt: skip
    axes.set_xlabel("stated chance that a pair is in order [%]")
    axes.set_ylabel("pairs in order [%]")
    axes.set_xlim(50, 102)
    axes.set_ylim(40, 102)
    axes.legend(title="worlds", loc="lower right", fontsize=8, title_fontsize=8)
    axes.grid(lw=0.4)
