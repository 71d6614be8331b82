"""Whether a policy exists at the four corners of the gains (the study's section V-B).

A policy exists at a corner if at least 99 % of the fresh episodes of all its policies together are
successes. So no policy is picked by the episodes that judge it. An interval is Wilson's, and about
these policies.
"""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from t2l.gains import Cell, corner_regions
from t2l.names import heading
from t2l.stats.learning import EXISTS
from t2l.stats.text import rate
from t2l.study.published.cells import passed_trials
from t2l.study.published.numbers import REGIONS

COLUMNS = ("task", "region", "kp", "kd", "episodes", "successes")
# ends of a task's name that say how it is learned or judged, not what the study calls it
VARIANTS = ("_isaaclab", "_by_distance")


def at_corners(policies: pd.DataFrame, cells: Mapping[str, Iterable[Cell]]) -> pd.DataFrame:
    """Those of tasks that are asked for at four corners, with the region of each.

    Args:
        policies: one row each; task, kp, kd and more.
        cells: that are asked for, by task.
    """
    known = {task: corner_regions(own) for task, own in cells.items()}
    rows = zip(policies.task, policies.kp, policies.kd, strict=True)
    found = [known.get(task, {}).get(Cell(kp, kd)) for task, kp, kd in rows]
    return policies.assign(region=found).dropna(subset="region")


def existence_table(policies: pd.DataFrame) -> pd.DataFrame:
    """One row a task and corner that has policies, by task and in order of `REGIONS`.

    Args:
        policies: one row each, columns `COLUMNS`.

    Returns:
        task, region, kp, kd, policies, episodes, successes, success, low, high, exists;
        published_passed of published_trials, the study's with at least 95 %, NaN where it
        publishes none.
    """
    order = list(dict.fromkeys(policies.task))
    counts = {"policies": ("episodes", "size"), "episodes": ("episodes", "sum"),
              "successes": ("successes", "sum")}  # fmt: skip
    table = policies.groupby([*COLUMNS[:4]], as_index=False).agg(**counts)
    table = table.sort_values(
        ["task", "region"],
        key=lambda own: own.map(order.index if own.name == "task" else REGIONS.index),
        ignore_index=True,
    )
    share = table.successes / table.episodes
    low, high = proportion_confint(table.successes, table.episodes, method="wilson")
    table = table.assign(success=share, low=low, high=high, exists=share >= EXISTS)
    published = [
        (passed.get(Cell(one.kp, one.kd), np.nan), of if passed else np.nan)
        for one in table.itertuples()
        for passed, of in [passed_trials(_of_study(one.task))]
    ]
    table[["published_passed", "published_trials"]] = np.reshape(published, (-1, 2))
    return table


def _of_study(task: str) -> str:
    """The task without what tells how it is learned."""
    for end in VARIANTS:
        task = task.removesuffix(end)
    return task


def printable_existence(table: pd.DataFrame) -> pd.DataFrame:
    """The table as text, a row a task."""
    rows = []
    for task, own in table.groupby("task", sort=False):
        corners = {one.region: one for one in own.itertuples()}
        theirs = own.set_index("region").published_passed.dropna()
        of = own.published_trials.iloc[0]
        rows.append(
            {
                "Task": heading(str(task)),
                **{region: _share(corners.get(region)) for region in REGIONS},
                "Policies": _counts(own.policies),
                "Episodes": _counts(own.episodes),
                "Exists": ", ".join(own.region[own.exists]) or "-",
                "Trials of the study": (
                    f"{', '.join(f'{k} {n:.0f}' for k, n in theirs.items())} of {of:.0f}"
                    if len(theirs)
                    else "-"
                ),
            }
        )
    return pd.DataFrame(rows)


def _share(one) -> str:
    """Of a row of the table; None where nothing was trained."""
    if one is None:
        return "not run"
    return f"{rate(one.success)} ({100 * one.low:.1f} to {100 * one.high:.1f})"


def _counts(values: pd.Series) -> str:
    """One number where all corners have the same."""
    return ", ".join(map(str, values if values.nunique() > 1 else values[:1]))
