"""The study's table of behaviour cloning: one row a task, cells the unit of replication."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.regions import COLUMNS, by_cell
from t2l.stats.slopes import share_slopes
from t2l.stats.text import estimate, latex, p_over_cells, rate
from t2l.stats.verdict import ALPHA, greater

__all__ = ["COLUMNS", "behaviour_cloning_table", "printable", "to_latex"]


def behaviour_cloning_table(
    cells: Mapping[str, pd.DataFrame], grid: Grid, alpha: float = ALPHA
) -> pd.DataFrame:
    """Success in the compliant, overdamped region G^CO and outside it, and what gains do to it.

    The study tests over rollouts (Barnard). Rollouts of one policy are no replications of its
    gains, so here a cell counts once.

    Args:
        cells: per task, one row a cell and training seed with columns `COLUMNS`.

    Returns:
        One row per task: task; success_co, success_rest, means over cells_co, cells_rest; beta_kp,
        beta_kd (log odds per doubling) with errors over cells; p of the one-sided Mann-Whitney
        test over cells that success is greater in G^CO, Bonferroni-corrected for the tasks, NaN
        where the least that the design attains exceeds α.
    """
    rows = []
    for task, table in cells.items():
        own = by_cell(table)
        inside = np.array(
            [
                grid.in_compliant_overdamped(Cell(kp, kd))
                for kp, kd in own[["kp", "kd"]].itertuples(index=False)
            ]
        )
        co, rest = own.success[inside].to_numpy(), own.success[~inside].to_numpy()
        fit = share_slopes(own.kp, own.kd, own.successes, own.rollouts)
        rows.append(
            {
                "task": task,
                "success_co": co.mean() if len(co) else np.nan,
                "cells_co": len(co),
                "success_rest": rest.mean() if len(rest) else np.nan,
                "cells_rest": len(rest),
                "beta_kp": fit.kp,
                "beta_kp_se": fit.kp_error,
                "beta_kd": fit.kd,
                "beta_kd_se": fit.kd_error,
                "p": greater(co, rest, alpha, len(cells)).p,
            }
        )
    return pd.DataFrame(rows)


def printable(table: pd.DataFrame) -> pd.DataFrame:
    """The table in the study's layout, as text: percentages, coefficients with errors."""
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Success in G^CO": _with_count(table.success_co, table.cells_co),
            "Success outside": _with_count(table.success_rest, table.cells_rest),
            "β log2 Kp": [estimate(*row) for row in _pairs(table, "beta_kp")],
            "β log2 Kd": [estimate(*row) for row in _pairs(table, "beta_kd")],
            "p": [p_over_cells(p) for p in table.p],
        }
    )


def _with_count(shares: pd.Series, cells: pd.Series) -> list[str]:
    return [
        f"{rate(share)} ({count} {'cell' if count == 1 else 'cells'})" if count else rate(share)
        for share, count in zip(shares, cells, strict=True)
    ]


def _pairs(table: pd.DataFrame, name: str) -> zip:
    return zip(table[name], table[f"{name}_se"], strict=True)


def to_latex(printed: pd.DataFrame) -> str:
    """A booktabs tabular of `printable`'s table."""
    headers = {
        "Success in G^CO": r"Success in $\mathcal{G}^{\mathrm{CO}}$",
        "Success outside": "Success outside",
        "β log2 Kp": r"$\beta_{\log_2 K_p}$",
        "β log2 Kd": r"$\beta_{\log_2 K_d}$",
        "p": "$p$",
    }
    return latex(printed, headers)
