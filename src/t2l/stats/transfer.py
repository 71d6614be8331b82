"""How transfer depends on the gains: the study's table, one row a condition."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan

import numpy as np
import pandas as pd
import statsmodels.api as sm

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.attainable import bonferroni, least_attainable_p, reportable
from t2l.stats.bootstrap import bootstrap_interval, mean
from t2l.stats.rank_tests import rank_sum_p
from t2l.stats.text import estimate, p_over_cells, p_value, rate
from t2l.stats.verdict import ALPHA

COLUMNS = (
    "kp", "kd", "seed", "trajectory_error", "jitter_failure", "jitter_failure_sim", "stopped"
)  # fmt: skip
# a real robot never agrees with a simulator to less than (10 µrad)²; errors of 0 have no logarithm
LEAST_ERROR = 1e-10
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
    """ln error = intercept + kp · log2 Kp + kd · log2 Kd, with standard errors and two-sided p.

    NaN where the data determine nothing: one gain only, or fewer cells than coefficients.
    """

    intercept: float = nan
    kp: float = nan
    kd: float = nan
    kp_error: float = nan
    kd_error: float = nan
    kp_p: float = nan
    kd_p: float = nan


def of_policies(rollouts: pd.DataFrame) -> pd.DataFrame:
    """One row a policy: kp, kd, seed, the mean of E, and its logarithm as `log`.

    The study averages E over the rollouts of a cell before it takes the logarithm. An E that is not
    a number makes its policy's mean none: nothing is left out unseen.
    """
    error = rollouts.groupby(["kp", "kd", "seed"], as_index=False).trajectory_error.agg(
        lambda values: values.mean(skipna=False)
    )
    return error.assign(log=np.log(np.maximum(error.trajectory_error, LEAST_ERROR)))


def log_error_regression(policies: pd.DataFrame) -> LogErrorFit:
    """Ordinary least squares over policies; standard errors are clustered by cell.

    Policies of a cell share a simulator and action scales, so that they are not independent. p is
    of Student's t with as many degrees of freedom as there are cells less one.

    Args:
        policies: as `of_policies` makes them.
    """
    gains = policies[["kp", "kd"]].to_numpy(float)
    design = sm.add_constant(np.log2(gains), has_constant="add")
    _, cluster = np.unique(gains, axis=0, return_inverse=True)
    cells = cluster.max() + 1 if len(cluster) else 0
    if cells < 4 or np.linalg.matrix_rank(design) < 3 or policies.log.isna().any():
        return LogErrorFit()
    model = sm.OLS(policies.log.to_numpy(), design)
    fit = model.fit() if cells == len(policies) else model.fit(
        cov_type="cluster", cov_kwds={"groups": cluster.ravel()}, use_t=True
    )  # fmt: skip
    return LogErrorFit(*map(float, (*fit.params, *fit.bse[1:], *fit.pvalues[1:])))


def transfer_table(
    rollouts: Mapping[str, pd.DataFrame], grid: Grid, alpha: float = ALPHA
) -> pd.DataFrame:
    """Error in the stiff, overdamped region G^SO and outside it, and what gains do to it.

    Args:
        rollouts: per condition, one row a rollout with columns `COLUMNS`.

    Returns:
        One row a condition: error_so, error_rest as means over rollouts, how many of rollouts and
        cells they are; beta_kp, beta_kd of ln error per doubling with standard errors; p_rollouts
        and p_cells of the one-sided Mann-Whitney U test that error is greater in G^SO, over
        rollouts as in the study and over the cells' geometric means, Bonferroni-corrected for the
        conditions. least_p_cells is what p_cells can attain at best; where that exceeds α, p_cells
        is NaN.
    """
    rows = []
    for name, table in rollouts.items():
        inside = _stiff_overdamped(table, grid)
        error = table.trajectory_error.to_numpy()
        policies = of_policies(table)
        fit = log_error_regression(policies)
        cells = policies.groupby(["kp", "kd"], as_index=False)["log"].mean()
        among = _stiff_overdamped(cells, grid)
        n_so, n_rest, tests = int(among.sum()), int((~among).sum()), len(rollouts)
        p_cells = bonferroni(rank_sum_p(cells.log[among], cells.log[~among]), tests)
        least = least_attainable_p(n_so, n_rest, tests)
        rows.append(
            {
                "condition": name,
                "error_so": error[inside].mean() if inside.any() else np.nan,
                "rollouts_so": int(inside.sum()),
                "cells_so": n_so,
                "error_rest": error[~inside].mean() if (~inside).any() else np.nan,
                "rollouts_rest": int((~inside).sum()),
                "cells_rest": n_rest,
                "policies": len(policies),
                "stopped_rate": (table.stopped != "").mean(),
                "beta_kp": fit.kp,
                "beta_kp_se": fit.kp_error,
                "beta_kd": fit.kd,
                "beta_kd_se": fit.kd_error,
                "p_rollouts": bonferroni(rank_sum_p(error[inside], error[~inside]), tests),
                "least_p_cells": least,
                "p_cells": reportable(p_cells, least, alpha),
            }
        )
    return pd.DataFrame(rows)


def jitter_table(
    rollouts: Mapping[str, pd.DataFrame], rates_hz: Mapping[str, float]
) -> pd.DataFrame:
    """How often rollouts jitter, by policy period, with 95 % bootstrap intervals over cells.

    Of all rollouts. One that was stopped shows no jitter; how many were is reported apart. Beside
    it how often they jitter in simulation, where a policy that shakes by itself shows.

    Args:
        rollouts: per condition, one row a rollout with columns `COLUMNS`.
        rates_hz: of the conditions' policies, those that differ in nothing else.
    """
    rows = []
    for name, hertz in sorted(rates_hz.items(), key=lambda item: 1 / item[1]):
        table = rollouts[name]
        by_cell = table.groupby(["kp", "kd"]).jitter_failure.mean().to_numpy(float)
        low, high = bootstrap_interval(mean, by_cell)
        rows.append(
            {
                "condition": name,
                "period_s": 1 / hertz,
                "jitter_rate": by_cell.mean(),
                "jitter_rate_sim": table.jitter_failure_sim.mean(),
                "stopped_rate": (table.stopped != "").mean(),
                "lower": low,
                "upper": high,
                "cells": len(by_cell),
                "rollouts": len(table),
            }
        )
    return pd.DataFrame(rows)


def existence_table(cells: Mapping[str, pd.DataFrame], grid: Grid) -> pd.DataFrame:
    """Success rate of the best policy in its simulator, a row a condition, a column a corner.

    Args:
        cells: per condition, one row a policy with columns `CELL_COLUMNS`.
    """
    rows = []
    for name, table in cells.items():
        by_cell = table.groupby(["kp", "kd"]).success_sim_100.max()
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
            "Cells": [f"{a} + {b}" for a, b in zip(table.cells_so, table.cells_rest, strict=True)],
            "Policies": [str(n) for n in table.policies],
            "Stopped": [rate(v) for v in table.stopped_rate],
            "β log2 Kp": [
                estimate(*row) for row in zip(table.beta_kp, table.beta_kp_se, strict=True)
            ],
            "β log2 Kd": [
                estimate(*row) for row in zip(table.beta_kd, table.beta_kd_se, strict=True)
            ],
            "p (rollouts)": [p_value(p) for p in table.p_rollouts],
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
            "Stopped": [rate(value) for value in table.stopped_rate],
            "Cells": [str(n) for n in table.cells],
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
