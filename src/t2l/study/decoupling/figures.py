"""Effective stiffness, over training and at its end, beside that of the bare controllers.

It is a stiffness where a policy holds its pose and yields steadily, `summary.holding`.
"""

from collections.abc import Mapping
from textwrap import fill

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from t2l.plotting.style import COLOURS, styled, title
from t2l.study.decoupling.summary import holding

COLUMNS = ("update", "stiffness_n_m", "passive_n_m", "drift", "success")
FORCE = "force over displacement |F|/|Δx| [N/m]"
LABEL = 14  # layout: letters of a line below a column
HOLDS, DOES_NOT = "holds its pose, yields steadily", "does not"


def stiffness_over_training(tables: Mapping[str, Mapping[int, pd.DataFrame]]) -> Figure:
    """A line a pairing: the median over directions and seeds, about it the half of them.

    Thin lines are seeds, each the median over directions, with a dot at each evaluation in which
    it holds its pose and yields steadily; dashed is the bare controller.

    Args:
        tables: of each pairing's seeds, columns `COLUMNS`.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(5.2, 3.6))
        for colour, (name, seeds) in zip(COLOURS, tables.items(), strict=False):
            groups = pd.concat(seeds.values()).groupby("update").stiffness_n_m
            low, middle, high = (groups.quantile(share) for share in (0.25, 0.5, 0.75))
            axes.fill_between(middle.index, low, high, color=colour, alpha=0.2, lw=0)
            axes.plot(middle.index, middle, color=colour, lw=2, label=f"{title(name)}")
            for table in seeds.values():
                medians = table.groupby("update")[[*COLUMNS[1:]]].median()
                axes.plot(medians.index, medians.stiffness_n_m, color=colour, lw=0.6)
                held = medians[holding(medians)]
                axes.plot(held.index, held.stiffness_n_m, "o", color=colour, ms=3)
            passive = next(iter(seeds.values())).passive_n_m.median()
            axes.axhline(passive, color=colour, ls="--", lw=1.2)
        axes.plot([], [], color="0.4", ls="--", lw=1.2, label="bare controller")
        axes.plot([], [], "o", color="0.4", ms=3, label=HOLDS)
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("updates of the policy")
        axes.set_ylabel(FORCE)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2, fontsize=8)
        count = max(len(seeds) for seeds in tables.values())
        axes.set_title(f"Stiffness of the tool over training, {count} seed{'s'[: count > 1]}")
    return figure


def stiffness_at_the_end(trainings: pd.DataFrame) -> Figure:
    """A column a pairing, a mark a training seed: filled where it is a stiffness, else open.

    Args:
        trainings: columns `summary.COLUMNS`.
    """
    with styled():
        names = list(dict.fromkeys(trainings.pairing))
        figure, axes = plt.subplots(figsize=(max(5.2, 1.1 * len(names)), 3.6))
        for place, name in enumerate(names):
            own, colour = trainings[trainings.pairing == name], COLOURS[place % len(COLOURS)]
            steps = (own.seed.rank(method="dense") - (own.seed.nunique() + 1) / 2) * 0.12
            for held, face in ((True, colour), (False, "none")):
                part = holding(own) == held
                axes.scatter(
                    place + steps[part], own.stiffness_n_m[part], s=36,
                    facecolor=face, edgecolor=colour,
                )  # fmt: skip
            axes.hlines(own.passive_n_m.median(), place - 0.3, place + 0.3, colour, "--", lw=1.2)
        axes.set_yscale("log")
        axes.set_xlim(-0.5, len(names) - 0.5)
        gains = trainings.groupby("pairing")[["kp", "kd"]].first()
        labels = [f"{fill(title(n), LABEL)}\nKp {gains.kp[n]:g}, Kd {gains.kd[n]:g}" for n in names]
        axes.set_xticks(range(len(names)), labels, fontsize=8)
        axes.set_ylabel(FORCE)
        mark = {"ls": "", "marker": "o", "color": "0.4"}
        handles = [
            Line2D([], [], label=HOLDS, **mark),
            Line2D([], [], label=DOES_NOT, markerfacecolor="none", **mark),
            Line2D([], [], label="bare controller", color="0.4", ls="--", lw=1.2),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
        held = int(holding(trainings).sum())
        axes.set_title(f"{held} of {len(trainings)} policies hold their pose and yield steadily")
    return figure
