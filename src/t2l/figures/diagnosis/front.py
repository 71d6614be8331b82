"""What each further number of a model buys, in one round of a search."""

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from t2l.diagnose.fronts import Front
from t2l.figures.diagnosis.panels import BLACK, BLUE, GREY, ORANGE
from t2l.plotting.style import plain_ticks, styled


def front(one: Front, floor: float) -> Figure:
    """Error on what was left out of the fit over fitted numbers; what was adopted is marked.

    Args:
        floor: rad, the error of a perfect model.
    """

    def points(chosen):
        sets = [one.tried[place] for place in chosen]
        return [s["numbers"] for s in sets], [1e3 * s["left_out_rmse_q_rad"] for s in sets]

    others = [place for place in range(len(one.tried)) if place != one.adopted]
    simulated = [place for place in others if one.tried[place]["simulated"]]
    linear = [place for place in others if not one.tried[place]["simulated"]]
    with styled():
        figure, axes = plt.subplots(figsize=(5.4, 3.4))
        before = 1e3 * one.before_rad
        axes.axhline(before, color=ORANGE, lw=1, label=f"before, {before:.3g} mrad")
        if len(one.best) > 1:
            axes.plot(*points(one.best), color=GREY, lw=1.2, drawstyle="steps-post", zorder=1)
        if linear:
            axes.plot(*points(linear), "o", color=GREY, mfc="none", ms=6, label="linear model only")
        if simulated:
            axes.plot(*points(simulated), "o", color=GREY, ms=6, label="simulated")
        if one.adopted is not None:
            axes.plot(*points([one.adopted]), "o", color=BLUE, ms=9, label="adopted")
        elif one.adopted_rad is not None:
            text = f"adopted, {1e3 * one.adopted_rad:.3g} mrad"
            axes.axhline(1e3 * one.adopted_rad, color=BLUE, lw=1.6, label=text)
        text = f"noise floor, {1e3 * floor:.2g} mrad"
        axes.axhline(1e3 * floor, color=BLACK, ls="--", lw=1, label=text)
        axes.set_yscale("log")
        plain_ticks(axes.yaxis)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlim(min(points(range(len(one.tried)))[0]) - 0.6, None)
        axes.set_xlabel("numbers fitted")
        axes.set_ylabel("RMS error on what was left out [mrad]")
        figure.legend(loc="outside upper center", ncols=3, fontsize=7)
    return figure
