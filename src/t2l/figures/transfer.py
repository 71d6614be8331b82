"""How far policies on the robot depart from their simulators, over the grid of gains."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from t2l.gains import Cell, Grid
from t2l.plotting.heatmap import error_norm, heatmap, height, matrix, width
from t2l.plotting.style import COLOURS, short, styled, title

if TYPE_CHECKING:
    import pandas as pd

JITTER_COLUMNS = (
    "period_s", "jitter_rate", "jitter_rate_sim", "stopped_rate", "lower", "upper", "cells",
    "rollouts",
)  # fmt: skip
CELL_COLUMNS = (
    "kp", "kd", "trajectory_error", "nn_error", "jitter_rate", "stopped_rate", "feedback_gain"
)  # fmt: skip
TRACE_COLUMNS = ("rollout", "where", "time")
OBSERVATION_COLUMNS = ("rollout", "where")
SHARES = ("jitter_rate", "stopped_rate")
WRIST = 3  # joints, the last of the arm


def error_maps(cells: Mapping[str, "pd.DataFrame"], grid: Grid) -> Figure:
    """A row a condition: E, error of the policy's outputs, its gain, what jitters, what is stopped.

    Args:
        cells: per condition, one row a cell, columns `CELL_COLUMNS`.
    """
    shown = (
        ("trajectory_error", "E [rad² + (rad/s)²]", "{:.2g}".format),
        ("nn_error", "policy outputs, RMS difference", "{:.2g}".format),
        ("feedback_gain", "feedback gain of the policy", "{:.2g}".format),
        ("jitter_rate", "jitter to their end [%]", lambda v: f"{100 * v:.0f}"),
        ("stopped_rate", "stopped by the guard [%]", lambda v: f"{100 * v:.0f}"),
    )
    with styled():
        figure, axes = plt.subplots(
            *(len(cells), len(shown)),
            figsize=(0.5 * len(shown) * width(grid), height(grid) * len(cells) + 0.3),
            squeeze=False,
        )
        for row, (name, table) in enumerate(cells.items()):
            for column, (key, label, text) in enumerate(shown):
                values = matrix(table, key, grid)
                norm = Normalize(0, 1)
                if key not in SHARES:
                    norm = error_norm(values.flat)
                panel = axes[row, column]
                heatmap(
                    panel, values, grid, "magma_r", norm, text, label,
                    percent=key in SHARES, region="SO",
                )  # fmt: skip
                if column == 0:
                    panel.set_ylabel(f"{title(name)}\n{panel.get_ylabel()}")
        figure.suptitle("Robot against its identified simulator", fontsize=11)
    return figure


def jitter_by_period(table: "pd.DataFrame") -> Figure:
    """Shares of rollouts that jitter and that were stopped against the policy's period.

    Intervals are of 95 %, over cells.

    Args:
        table: as `t2l.stats.transfer.jitter_table` makes it.
    """
    with styled():
        figure, axes = plt.subplots(figsize=(4.2, 3.0))
        period, share = 1000 * table.period_s, 100 * table.jitter_rate
        spread = [share - 100 * table.lower, 100 * table.upper - share]
        axes.errorbar(
            period,
            share,
            yerr=np.maximum(spread, 0),
            fmt="o-",
            capsize=3,
            label="jitter on the robot",
        )
        axes.plot(
            period, 100 * table.jitter_rate_sim, "s--", mfc="none", label="jitter in its simulator"
        )
        axes.plot(
            period,
            100 * table.stopped_rate,
            "^:",
            mfc="none",
            c="0.5",
            label="stopped on the robot",
        )
        axes.legend(fontsize=8)
        axes.set_xlabel("policy period [ms]")
        axes.set_ylabel("rollouts [%]", fontsize=8)
        axes.set_xticks(period, [f"{p:.0f}" for p in period])
        axes.set_ylim(-3, 103)
        axes.set_title(f"{table.cells.max()} cells; 95 % intervals over cells", fontsize=9)
    return figure


def wrist_trajectories(traces: Mapping[Cell, "pd.DataFrame"], captions: Sequence[str]) -> Figure:
    """A column a cell, a row a wrist joint: velocity on the robot and in its simulator.

    Args:
        traces: of one rollout each, columns `TRACE_COLUMNS` and `dq.JOINT` of every joint in order.
        captions: of the columns.
    """
    joints = _joints(next(iter(traces.values())), "dq")
    labels, wrist = short(joints), joints[-WRIST:]
    with styled():
        figure, axes = plt.subplots(
            *(len(wrist), len(traces)),
            figsize=(3.4 * len(traces) + 0.6, 1.6 * len(wrist)),
            sharex=True,
            sharey="row",
            squeeze=False,
        )
        for column, ((cell, trace), caption) in enumerate(
            zip(traces.items(), captions, strict=True)
        ):
            for row, joint in enumerate(wrist):
                panel = axes[row, column]
                for where, colour, label in (
                    ("real", COLOURS[0], "robot"),
                    ("sim", COLOURS[1], "identified simulator"),
                ):
                    part = trace[trace["where"] == where]
                    panel.plot(part.time, part[f"dq.{joint}"], color=colour, lw=0.9, label=label)
                if column == 0:
                    panel.set_ylabel(f"{labels[joint]}\nvelocity [rad/s]", fontsize=8)
            axes[0, column].set_title(f"{cell}\n{caption}", fontsize=9)
            axes[-1, column].set_xlabel("time [s]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.align_ylabels()
        figure.suptitle("A policy's wrist on the robot and in simulation", fontsize=11)
    return figure


def observation_distributions(observations: Mapping[Cell, "pd.DataFrame"]) -> Figure:
    """A row a cell, a column an observation: densities on the robot and in its simulator.

    Of a joint near the base and one near the flange.

    Args:
        observations: columns `OBSERVATION_COLUMNS`, and `q.JOINT`, `dq.JOINT`, `action.JOINT` of
            every joint in order.
    """
    joints = _joints(next(iter(observations.values())), "q")
    labels = short(joints)
    near_base, near_flange = joints[:2][-1], joints[-2:][0]
    both = dict.fromkeys((near_base, near_flange))
    columns = [*(f"{signal}.{joint}" for signal in ("q", "dq") for joint in both),
               f"action.{near_flange}"]  # fmt: skip
    with styled():
        figure, axes = plt.subplots(
            *(len(observations), len(columns)),
            figsize=(2.3 * len(columns) + 0.6, 1.6 * len(observations) + 0.9),
            squeeze=False,
        )
        for row, (cell, table) in enumerate(observations.items()):
            for column, name in enumerate(columns):
                panel = axes[row, column]
                edges = np.histogram_bin_edges(table[name], bins=40)
                for where, colour, label in (
                    ("real", COLOURS[0], "robot"),
                    ("sim", COLOURS[1], "identified simulator"),
                ):
                    panel.hist(
                        table.loc[table["where"] == where, name],
                        bins=edges, density=True, histtype="step", color=colour, label=label,
                    )  # fmt: skip
                panel.set_yticks([])
                panel.tick_params(labelsize=7)
                if row == len(observations) - 1:
                    signal, _, joint = name.partition(".")
                    label = f"{signal}.{labels[joint]} [{_unit(name)}]"
                    panel.set_xlabel(label, fontsize=8)
            axes[row, 0].set_ylabel(str(cell), fontsize=8)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.suptitle("What policies see on the robot and in simulation", fontsize=11)
    return figure


def _joints(table: "pd.DataFrame", signal: str) -> list[str]:
    return [name.partition(".")[2] for name in table.columns if name.startswith(f"{signal}.")]


def _unit(name: str) -> str:
    return {"q": "rad", "dq": "rad/s", "action": "1"}[name.partition(".")[0]]
