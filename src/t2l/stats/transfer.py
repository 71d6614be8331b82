"""How transfer depends on the gains: the study's table, one row a condition."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import statsmodels.api as sm
from statsmodels.stats.proportion import proportion_confint

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.attainable import least_attainable_p, reportable
from t2l.stats.barnard import bonferroni
from t2l.stats.rank_tests import rank_sum_p
from t2l.stats.text import estimate, p_over_cells, p_value, rate
from t2l.stats.verdict import ALPHA

COLUMNS = ("kp", "kd", "trajectory_error", "jitter_failure", "jitter_failure_sim")
# of columns that LaTeX writes otherwise
HEADERS = {
    "Error in G^SO": r"Error in $\mathcal{G}^{\mathrm{SO}}$",
    "β log2 Kp": r"$\beta_{\log_2 K_p}$",
    "β log2 Kd": r"$\beta_{\log_2 K_d}$",
    "p (rollouts)": "$p$ (rollouts)",
    "p (cells)": "$p$ (cells)",
}
CELL_COLUMNS = ("kp", "kd", "success_sim_100")


@dataclass(frozen=True)
class LogErrorFit:
    """ln error = intercept + kp · log2 Kp + kd · log2 Kd, with standard errors.

    NaN where the data determine nothing: one gain only, or fewer cells than coefficients.
    """

    intercept: float
    kp: float
    kd: float
    kp_error: float
    kd_error: float


def log_error_regression(kp: np.ndarray, kd: np.ndarray, error: np.ndarray) -> LogErrorFit:
    """Ordinary least squares, one row a rollout; standard errors are clustered by cell.

    Rollouts of a cell share a policy and a simulator, so that they are not independent.

    Args:
        kp, kd: (n,) gains of each rollout.
        error: (n,) positive.
    """
    gains = np.column_stack([kp, kd])
    design = sm.add_constant(np.log2(gains), has_constant="add")
    _, cluster = np.unique(gains, axis=0, return_inverse=True)
    cells = cluster.max() + 1
    if np.linalg.matrix_rank(design) < 3 or cells < 4:
        return LogErrorFit(*[float("nan")] * 5)
    model = sm.OLS(np.log(error), design)
    fit = model.fit() if cells == len(error) else model.fit(
        cov_type="cluster", cov_kwds={"groups": cluster}
    )  # fmt: skip
    return LogErrorFit(*fit.params, *fit.bse[1:])


def transfer_table(
    rollouts: Mapping[str, pd.DataFrame], grid: Grid, alpha: float = ALPHA
) -> pd.DataFrame:
    """Error in the stiff, overdamped region G^SO and outside it, and what gains do to it.

    Args:
        rollouts: per condition, one row a rollout with columns `COLUMNS`.

    Returns:
        One row a condition: error_so, error_rest as means over rollouts, how many of them; beta_kp,
        beta_kd of ln error per doubling with standard errors; p_rollouts and p_cells of the
        one-sided Mann-Whitney U test that error is greater in G^SO, over rollouts as in the study
        and over the cells' geometric means, Bonferroni-corrected for the conditions. cells_so and
        cells_rest say over how many, least_p_cells what they can attain at best; where that
        exceeds α, p_cells is NaN.
    """
    rows = []
    for name, table in rollouts.items():
        known = table[np.isfinite(table.trajectory_error) & (table.trajectory_error > 0)]
        inside = _stiff_overdamped(known, grid)
        error = known.trajectory_error.to_numpy()
        fit = log_error_regression(known.kp.to_numpy(), known.kd.to_numpy(), error)
        cells = known.assign(log=np.log(error)).groupby(["kp", "kd"], as_index=False)["log"].mean()
        among = _stiff_overdamped(cells, grid)
        n_so, n_rest, tests = int(among.sum()), int((~among).sum()), len(rollouts)
        p_cells = bonferroni(rank_sum_p(cells.log[among], cells.log[~among]), tests)
        least = least_attainable_p(n_so, n_rest, tests)
        rows.append(
            {
                "condition": name,
                "error_so": error[inside].mean() if inside.any() else np.nan,
                "rollouts_so": int(inside.sum()),
                "error_rest": error[~inside].mean() if (~inside).any() else np.nan,
                "rollouts_rest": int((~inside).sum()),
                "beta_kp": fit.kp,
                "beta_kp_se": fit.kp_error,
                "beta_kd": fit.kd,
                "beta_kd_se": fit.kd_error,
                "p_rollouts": bonferroni(rank_sum_p(error[inside], error[~inside]), tests),
                "cells_so": n_so,
                "cells_rest": n_rest,
                "least_p_cells": least,
                "p_cells": reportable(p_cells, least, alpha),
            }
        )
    return pd.DataFrame(rows)


def jitter_table(
    rollouts: Mapping[str, pd.DataFrame], rates_hz: Mapping[str, float]
) -> pd.DataFrame:
    """How often rollouts jitter, by policy period, with 95 % Wilson intervals.

    Of rollouts that were not stopped too early to tell; beside it how often they jitter in
    simulation, where a policy that shakes by itself shows.

    Args:
        rollouts: per condition, one row a rollout with columns `COLUMNS`.
        rates_hz: of the conditions' policies, those that differ in nothing else.
    """
    rows = []
    for name, hertz in sorted(rates_hz.items(), key=lambda item: 1 / item[1]):
        failed = rollouts[name].jitter_failure.astype(float).dropna()
        low = high = np.nan
        if len(failed):
            low, high = proportion_confint(failed.sum(), len(failed), method="wilson")
        rows.append(
            {
                "condition": name,
                "period_s": 1 / hertz,
                "jitter_rate": failed.mean(),
                "jitter_rate_sim": rollouts[name].jitter_failure_sim.astype(float).mean(),
                "lower": low,
                "upper": high,
                "rollouts": len(failed),
            }
        )
    return pd.DataFrame(rows)


def existence_table(cells: Mapping[str, pd.DataFrame], grid: Grid) -> pd.DataFrame:
    """Success rate of the best policy in its simulator, a row a condition, a column a corner.

    Args:
        cells: per condition, one row a cell with columns `CELL_COLUMNS`.
    """
    rows = []
    for name, table in cells.items():
        by_cell = table.set_index(["kp", "kd"]).success_sim_100
        corners = {
            f"{grid.region(cell)} {cell}": by_cell.get((cell.kp, cell.kd), np.nan)
            for cell in grid.corners
        }
        rows.append({"condition": name} | corners)
    return pd.DataFrame(rows)


def printable_transfer(table: pd.DataFrame) -> pd.DataFrame:
    """`transfer_table` in the study's layout, as text."""
    return pd.DataFrame(
        {
            "Condition": [heading(name) for name in table.condition],
            "Error in G^SO": [_number(v) for v in table.error_so],
            "Error outside": [_number(v) for v in table.error_rest],
            "β log2 Kp": [
                estimate(*row) for row in zip(table.beta_kp, table.beta_kp_se, strict=True)
            ],
            "β log2 Kd": [
                estimate(*row) for row in zip(table.beta_kd, table.beta_kd_se, strict=True)
            ],
            "p (rollouts)": [p_value(p) for p in table.p_rollouts],
            "Cells": [
                f"{so} + {rest}" for so, rest in zip(table.cells_so, table.cells_rest, strict=True)
            ],
            "p (cells)": [p_over_cells(p) for p in table.p_cells],
        }
    )


def printable_jitter(table: pd.DataFrame) -> pd.DataFrame:
    """`jitter_table` as text."""
    return pd.DataFrame(
        {
            "Policy period": [f"{1000 * period:.0f} ms" for period in table.period_s],
            "Jitter": [rate(value) for value in table.jitter_rate],
            "95 % interval": [
                f"{100 * low:.1f} to {100 * high:.1f} %"
                for low, high in zip(table.lower, table.upper, strict=True)
            ],
            "Rollouts": [str(n) for n in table.rollouts],
            "Jitter in simulation": [rate(value) for value in table.jitter_rate_sim],
        }
    )


def printable_existence(table: pd.DataFrame) -> pd.DataFrame:
    """`existence_table` as text."""
    printed = pd.DataFrame({"Condition": [heading(name) for name in table.condition]})
    for corner in table.columns[1:]:
        printed[corner] = ["not run" if pd.isna(value) else rate(value) for value in table[corner]]
    return printed


def _stiff_overdamped(table: pd.DataFrame, grid: Grid) -> np.ndarray:
    gains = zip(table.kp, table.kd, strict=True)
    return np.array([grid.region(Cell(kp, kd)) == "SO" for kp, kd in gains], bool)


def _number(value: float) -> str:
    return "no cells" if pd.isna(value) else f"{value:.3g}"
