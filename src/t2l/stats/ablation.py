"""Which effect of a robot makes policies shake: what changes when it is left out."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from t2l.gains import Cell
from t2l.stats.bootstrap import bootstrap_interval, mean
from t2l.stats.text import rate

WHOLE = "whole robot"
COLUMNS = ("kp", "kd", "seed", "trajectory_error", "jitter_failure", "jitter_failure_sim")


def by_cell(rollouts: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """One row an effect that is left out and a cell: `jitter_rate`, `error`, `policies`.

    Args:
        rollouts: by effect, and of `WHOLE`, columns `COLUMNS`; the same policies in each.
    """
    parts = []
    for effect, table in rollouts.items():
        groups = table.groupby(["kp", "kd"])
        means = groups[["jitter_failure", "jitter_failure_sim", "trajectory_error"]].mean()
        means = means.astype(float).assign(effect=effect, policies=groups.seed.nunique())
        parts.append(means.reset_index())
    names = {
        "jitter_failure": "jitter_rate", "jitter_failure_sim": "jitter_rate_sim",
        "trajectory_error": "error",
    }  # fmt: skip
    return pd.concat(parts, ignore_index=True).rename(columns=names)


def ablation_table(cells: pd.DataFrame, inside: Mapping[Cell, bool]) -> pd.DataFrame:
    """What leaving each effect out changes in the region G^SO and outside it.

    Args:
        cells: as `by_cell` makes them.
        inside: of each cell, whether it is in G^SO.

    Returns:
        A row an effect and region: mean share of rollouts that jitter over cells, how much less it
        is than on the whole robot (positive: the effect makes them shake), with a 95 % bootstrap
        interval over cells, of `cells` and `policies`.
    """
    cells = cells.assign(
        inside=[inside[Cell(kp, kd)] for kp, kd in zip(cells.kp, cells.kd, strict=True)]
    )
    whole = cells[cells.effect == WHOLE].set_index(["kp", "kd"]).jitter_rate
    rows = []
    for (effect, where), part in cells.groupby(["effect", "inside"], sort=False):
        less = (whole - part.set_index(["kp", "kd"]).jitter_rate).dropna().to_numpy()
        low, high = bootstrap_interval(mean, less)
        rows.append(
            {
                "without": effect,
                "region": "G^SO" if where else "outside",
                "jitter_rate": part.jitter_rate.mean(),
                "less": less.mean(),
                "lower": low,
                "upper": high,
                "error": part.error.mean(),
                "cells": len(part),
                "policies": int(part.policies.sum()),
            }
        )
    return pd.DataFrame(rows)


def printable_ablation(table: pd.DataFrame) -> pd.DataFrame:
    """`ablation_table` as text."""

    def spread(row: pd.Series) -> str:
        if row.without == WHOLE:
            return ""
        if np.isnan(row.lower):
            return f"{100 * row.less:+.0f} % (too few cells)"
        low, high = (f"{100 * value:+.0f}" for value in (row.lower, row.upper))
        return f"{100 * row.less:+.0f} % ({low} to {high})"

    return pd.DataFrame(
        {
            "Without": [name.replace("_", " ") for name in table.without],
            "Cells": [f"{n} {where}" for n, where in zip(table.cells, table.region, strict=True)],
            "Policies": table.policies.astype(str),
            "Jitter": [rate(value) for value in table.jitter_rate],
            "Less than the whole robot (95 %)": [spread(row) for _, row in table.iterrows()],
            "E": [f"{value:.3g}" for value in table.error],
        }
    )
