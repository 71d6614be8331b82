"""Success by region of gains, with cells as the unit of replication."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.attainable import least_attainable_p
from t2l.stats.bootstrap import bootstrap_interval, mean
from t2l.stats.slopes import share_slopes
from t2l.stats.text import p_over_cells, rate
from t2l.stats.verdict import ALPHA, greater

REGIONS = ("CO", "SO", "CU", "SU")
COLUMNS = ("kp", "kd", "success", "rollouts")


def by_cell(cells: pd.DataFrame) -> pd.DataFrame:
    """One row a cell out of one a cell and training seed: means over seeds, sums of rollouts.

    Returns:
        Columns kp, kd, seeds, rollouts, successes, success (the mean over seeds).
    """
    known = cells.assign(successes=cells.success * cells.rollouts)
    return known.groupby(["kp", "kd"], as_index=False).agg(
        seeds=("success", "size"),
        rollouts=("rollouts", "sum"),
        successes=("successes", "sum"),
        success=("success", "mean"),
    )


def region_table(
    cells: Mapping[str, pd.DataFrame], grid: Grid, alpha: float = ALPHA
) -> pd.DataFrame:
    """Mean success in each region, and whether cells of one succeed more than others.

    Args:
        cells: by name of a task or variant, one row a cell and seed, columns `COLUMNS`.

    Returns:
        A row each: name; seeds, the fewest that a cell has; for CO, SO, CU, SU: cells_*, success_*
        as the mean over cells, lower_*, upper_* its 95 % bootstrap interval over cells; beta_kp,
        beta_kd with errors over cells; p_co_rest, p_co_so, p_co_cu of the one-sided Mann-Whitney
        test over cells that success is greater in CO, the first corrected for the rows
        (Bonferroni), each with least_p_* that its design attains, and NaN where that exceeds α.
    """
    rows = []
    for name, table in cells.items():
        own = by_cell(table)
        region = np.array(
            [grid.region(Cell(kp, kd)) for kp, kd in zip(own.kp, own.kd, strict=True)]
        )
        success = {word: own.success[region == word].to_numpy() for word in REGIONS}
        row = {"name": name, "seeds": int(own.seeds.min()), "cells": len(own)}
        for word, values in success.items():
            lower, upper = bootstrap_interval(mean, values)
            row |= {
                f"cells_{word.lower()}": len(values),
                f"success_{word.lower()}": values.mean() if len(values) else np.nan,
                f"lower_{word.lower()}": lower,
                f"upper_{word.lower()}": upper,
            }
        fit = share_slopes(own.kp, own.kd, own.successes, own.rollouts)
        row |= {"beta_kp": fit.kp, "beta_kp_se": fit.kp_error}
        row |= {"beta_kd": fit.kd, "beta_kd_se": fit.kd_error}
        others = np.concatenate([success[word] for word in REGIONS[1:]])
        for key, outside, tests in (
            ("co_rest", others, len(cells)),
            ("co_so", success["SO"], 1),
            ("co_cu", success["CU"], 1),
        ):
            row[f"p_{key}"] = greater(success["CO"], outside, alpha, tests).p
            row[f"least_p_{key}"] = least_attainable_p(len(success["CO"]), len(outside), tests)
        rows.append(row)
    return pd.DataFrame(rows)


def printable_regions(table: pd.DataFrame) -> pd.DataFrame:
    """`region_table` as text."""
    columns = {
        "Name": [heading(name) for name in table.name],
        "Cells × seeds": [f"{c} × {s}" for c, s in zip(table.cells, table.seeds, strict=True)],
    }
    for word in REGIONS:
        key = word.lower()
        columns[word] = [
            _with_interval(*row)
            for row in table[[f"success_{key}", f"lower_{key}", f"upper_{key}"]].itertuples(
                index=False
            )
        ]
    for key, title in (("co_rest", "p (CO > rest)"), ("co_so", "p (CO > SO)")):
        columns[title] = [p_over_cells(p) for p in table[f"p_{key}"]]
    return pd.DataFrame(columns)


def _with_interval(value: float, lower: float, upper: float) -> str:
    if np.isnan(lower):
        return rate(value)
    return f"{rate(value)} ({100 * lower:.0f} to {100 * upper:.0f})"
