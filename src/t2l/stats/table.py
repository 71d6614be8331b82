"""The study's table of behaviour cloning: one row per task."""

from collections.abc import Mapping

import pandas as pd

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.barnard import barnard_greater, bonferroni
from t2l.stats.logistic import logistic_regression
from t2l.stats.text import estimate, latex, p_value, rate

COLUMNS = ("kp", "kd", "success")


def behaviour_cloning_table(rollouts: Mapping[str, pd.DataFrame], grid: Grid) -> pd.DataFrame:
    """Success in the compliant, overdamped region G^CO and outside it, and what gains do to it.

    Args:
        rollouts: per task, one row per rollout with columns `COLUMNS`.

    Returns:
        One row per task: task; success_co, success_rest as fractions of rollouts_co,
        rollouts_rest; beta_kp, beta_kd with standard errors (log odds per doubling); p of
        Barnard's test that success is greater in G^CO, Bonferroni-corrected for the tasks.
    """
    rows = []
    for task, table in rollouts.items():
        inside = [
            grid.in_compliant_overdamped(Cell(kp, kd))
            for kp, kd in table[["kp", "kd"]].itertuples(index=False)
        ]
        co, rest = table.success[inside], table.success[[not i for i in inside]]
        fit = logistic_regression(table.kp, table.kd, table.success)
        compared = len(co) > 0 and len(rest) > 0
        p = (
            bonferroni(barnard_greater(co.sum(), len(co), rest.sum(), len(rest)), len(rollouts))
            if compared
            else float("nan")
        )
        rows.append(
            {
                "task": task,
                "success_co": co.mean(),
                "rollouts_co": len(co),
                "success_rest": rest.mean(),
                "rollouts_rest": len(rest),
                "beta_kp": fit.kp,
                "beta_kp_se": fit.kp_error,
                "beta_kd": fit.kd,
                "beta_kd_se": fit.kd_error,
                "p": p,
            }
        )
    return pd.DataFrame(rows)


def printable(table: pd.DataFrame) -> pd.DataFrame:
    """The table in the study's layout, as text: percentages, coefficients with errors."""
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Success in G^CO": [rate(s) for s in table.success_co],
            "Success outside": [rate(s) for s in table.success_rest],
            "β log2 Kp": [estimate(*row) for row in _pairs(table, "beta_kp")],
            "β log2 Kd": [estimate(*row) for row in _pairs(table, "beta_kd")],
            "p": [p_value(p) for p in table.p],
        }
    )


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
