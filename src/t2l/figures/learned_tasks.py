"""How tasks were learned: success, and what each term of the reward paid."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from t2l.plotting.style import COLOURS, styled, title

if TYPE_CHECKING:
    import pandas as pd

TERM = "reward_"  # and the name of a term
SMALL = 0.01  # what is paid below it is drawn to scale, above it by its logarithm
BELOW = (0.5, -0.2)  # a panel, clear of its label
COLUMNS = ("steps", "success", "kp", "kd", "seed")


def learned_tasks(curves: Mapping[str, "pd.DataFrame"]) -> Figure:
    """A column a task: success of each policy; below it what terms pay the one with most success.

    Args:
        curves: of each task, columns `COLUMNS` and one a term of the reward, `reward_…`.
    """
    with styled():
        figure, axes = plt.subplots(
            2, len(curves), figsize=(3.6 * len(curves) + 0.6, 6.4), squeeze=False
        )
        for column, (name, table) in enumerate(curves.items()):
            above, below = axes[:, column]
            policies = table.groupby(["kp", "kd", "seed"])
            for i, ((kp, kd, seed), part) in enumerate(policies):
                colour, label = COLOURS[i % len(COLOURS)], f"Kp {kp:g}, Kd {kd:g}, policy {seed}"
                above.plot(part.steps / 1e6, 100 * part.success, color=colour, label=label)
            above.set_ylim(-3, 103)
            above.set_title(title(name), fontsize=9)
            above.legend(fontsize=7, loc="upper center", bbox_to_anchor=BELOW)
            # of equals the first
            kp, kd, seed = best = policies.success.max().idxmax()
            shown = policies.get_group(best)
            terms = [term for term in table.columns if term.startswith(TERM)]
            for i, term in enumerate(terms):
                label = term.removeprefix(TERM).replace("_", " ")
                style = "-" if i < len(COLOURS) else "--"
                below.plot(
                    shown.steps / 1e6, shown[term], style, color=COLOURS[i % len(COLOURS)],
                    label=label,
                )  # fmt: skip
            below.set_yscale("symlog", linthresh=SMALL)
            below.set_title(f"Kp {kp:g}, Kd {kd:g}, policy {seed}", fontsize=8)
            below.legend(fontsize=7, loc="upper center", bbox_to_anchor=BELOW, ncols=2)
            for panel in (above, below):
                panel.set_xlabel("environment steps [million]")
        axes[0, 0].set_ylabel("success in evaluation [%]")
        axes[1, 0].set_ylabel("paid a second, by term")
    return figure
