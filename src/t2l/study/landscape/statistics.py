"""How easily action scales are found, at the corners of the grid."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from t2l.gains import Cell, Grid
from t2l.names import heading
from t2l.stats.text import rate
from t2l.study.passing import passes
from t2l.study.published.cells import passed_trials


@dataclass(frozen=True, eq=False)
class Searched:
    """A condition at a cell.

    Attributes:
        trials: of its search, columns `again.COLUMNS`.
        again: of configurations that were trained again, columns `again.CURVE_COLUMNS`.
    """

    condition: str
    cell: Cell
    trials: pd.DataFrame
    again: pd.DataFrame


def landscape_table(
    searched: Sequence[Searched], grid: Grid, passed: float, exists: float
) -> pd.DataFrame:
    """One row a condition and cell.

    Args:
        passed: success rate that a trial passes, see `t2l.study.passing`.
        exists: success rate from which a solution exists, the study's 0.99.

    Returns:
        condition, kp, kd, region; trials, those that were completed; passed, how many of them;
        best_success, exists; configurations that were trained again, runs, passed_again, how many
        runs passed at some evaluation, always_again, how many configurations did so with every
        seed; published_passed of published_trials, the study's, NaN for cells that it does not
        show.
    """
    published, of = passed_trials()
    rows = []
    for one in searched:
        complete = one.trials[one.trials.state == "complete"]
        runs = passes(one.again.groupby(["configuration", "seed"]).success.max(), passed)
        best = complete.success.max() if len(complete) else float("nan")
        rows.append(
            {
                "condition": one.condition,
                "kp": one.cell.kp,
                "kd": one.cell.kd,
                "region": grid.region(one.cell),
                "trials": len(complete),
                "passed": int(passes(complete.success, passed).sum()),
                "best_success": best,
                "exists": bool(best >= exists),
                "configurations": one.again.configuration.nunique(),
                "runs": len(runs),
                "passed_again": int(runs.sum()),
                "always_again": int(runs.groupby("configuration").all().sum()),
                "published_passed": published.get(one.cell, float("nan")),
                "published_trials": of,
            }
        )
    return pd.DataFrame(rows)


def printable_landscape(table: pd.DataFrame) -> pd.DataFrame:
    """`landscape_table` as text."""
    cells = (str(Cell(kp, kd)) for kp, kd in zip(table.kp, table.kd, strict=True))
    published = zip(table.published_passed, table.published_trials, strict=True)
    return pd.DataFrame(
        {
            "Condition": [heading(name) for name in table.condition],
            "Cell": [f"{r} {cell}" for r, cell in zip(table.region, cells, strict=True)],
            "Trials that pass": _of(table.passed, table.trials),
            "The study": ["–" if pd.isna(n) else f"{n:.0f} of {of}" for n, of in published],
            "Best": ["none" if pd.isna(best) else rate(best) for best in table.best_success],
            "A solution exists": ["yes" if found else "no" for found in table.exists],
            "Trained again": table.configurations.astype(str),
            "Runs that pass": _of(table.passed_again, table.runs),
            "With every seed": _of(table.always_again, table.configurations),
        }
    )


def _of(counts: pd.Series, totals: pd.Series) -> list[str]:
    return [f"{n} of {of}" for n, of in zip(counts, totals, strict=True)]
