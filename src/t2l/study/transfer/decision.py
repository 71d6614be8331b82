"""Whether the study's claim about transfer is reproduced, by a rule written before the runs.

The claim (section IV-C): stiff, overdamped gains transfer worse, and their failure is oscillation.
It is reproduced if all of this holds at the level α:

1. ln E grows with log2 Kp: β > 0, two-sided p of least squares over policies, clustered by cell;
2. ln E grows with log2 Kd: the same;
3. what jitters on the robot beyond what jitters in simulation, as a share of rollouts, is greater
   in the region G^SO: one-sided Mann-Whitney U test over cells. What was stopped does not jitter.

If one of them does not hold, the claim is not reproduced. Where too few cells have a policy that
works in its own simulator, it cannot be told. Beside the rule, and no part of it: rank correlations
over cells of E with the study's published errors, and of E with the policies' feedback gains.
"""

from math import nan
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from t2l.stats.attainable import least_attainable_p
from t2l.stats.rank_tests import rank_sum_p
from t2l.stats.text import p_value
from t2l.stats.transfer import log_error_regression, of_policies
from t2l.stats.verdict import Verdict
from t2l.study.published.cells import errors
from t2l.study.transfer.rule import Rule

DECISION_COLUMNS = ["what", "found", "error", "p", "cells", "policies", "holds"]
POLICY_COLUMNS = ("kp", "kd", "seed", "success_sim_100", "feedback_gain")


def decide(rollouts: pd.DataFrame, policies: pd.DataFrame, rule: Rule) -> pd.DataFrame:
    """Apply a rule.

    Args:
        rollouts: of the rule's condition, columns `t2l.stats.transfer.COLUMNS`.
        policies: of that condition, one row each, columns `POLICY_COLUMNS`.

    Returns:
        A row for each requirement, for what stands beside, and last for the verdict: `what`,
        `found`, `error` where it has one, `p`, `cells`, `policies`, `holds` (yes, no, or nothing).
    """
    key = ["kp", "kd", "seed"]
    works = policies[policies.success_sim_100 >= rule.success]
    if works.empty:
        nothing = {"what": "verdict", "cells": 0, "policies": 0, "holds": str(Verdict.CANNOT_TELL)}
        return pd.DataFrame([nothing], columns=DECISION_COLUMNS)
    rollouts = rollouts.merge(works[key], on=key)
    each = of_policies(rollouts).merge(works, on=key)
    fit = log_error_regression(each)
    cells = _cells(rollouts, each)
    inside = rule.inside(cells.kp, cells.kd)
    enough = (
        len(cells) >= rule.cells and least_attainable_p(inside.sum(), (~inside).sum()) <= rule.alpha
    )
    more, less = cells.excess[inside], cells.excess[~inside]
    rows = [
        _requirement("slope of ln E per doubling of Kp", fit.kp, fit.kp_p, rule, fit.kp_error),
        _requirement("slope of ln E per doubling of Kd", fit.kd, fit.kd_p, rule, fit.kd_error),
        _requirement(
            "jitter on the robot beyond simulation, in G^SO less outside",
            more.mean() - less.mean(), rank_sum_p(more, less), rule,
        ),
        _beside("rank correlation of E with the study's cells", cells.log, cells.published),
        _beside("rank correlation of E with the feedback gain", cells.log, cells.feedback_gain),
    ]  # fmt: skip
    held = [row["holds"] for row in rows[:3]]
    verdict = Verdict.REPRODUCED if all(h == "yes" for h in held) else Verdict.NOT_REPRODUCED
    if not enough or any(np.isnan(row["p"]) for row in rows[:3]):
        verdict = Verdict.CANNOT_TELL
    rows.append({"what": "verdict", "holds": str(verdict)})
    counts = {"cells": len(cells), "policies": len(each)}
    return pd.DataFrame([counts | row for row in rows], columns=DECISION_COLUMNS)


def printable_decision(table: pd.DataFrame) -> pd.DataFrame:
    """`decide` as text."""

    def number(value: float) -> str:
        return "" if pd.isna(value) else f"{value:+.3f}"

    spread = [f" ± {error:.3f}" if pd.notna(error) else "" for error in table.error]
    return pd.DataFrame(
        {
            "Requirement": table.what,
            "Found": [number(v) + e for v, e in zip(table.found, spread, strict=True)],
            "p": ["" if pd.isna(p) else p_value(p) for p in table.p],
            "Cells": table.cells.astype(str),
            "Policies": table.policies.astype(str),
            "Holds": table.holds.fillna(""),
        }
    )


def _requirement(
    what: str, found: float, p: float, rule: Rule, error: float = nan
) -> dict[str, Any]:
    holds = "yes" if found > 0 and p < rule.alpha else "no"
    return {"what": what, "found": found, "error": error, "p": p, "holds": holds}


def _beside(what: str, values: pd.Series, others: pd.Series) -> dict[str, Any]:
    known = values.notna() & others.notna()
    found = nan
    if known.sum() > 2 and values[known].nunique() > 1 and others[known].nunique() > 1:
        found = float(spearmanr(values[known], others[known]).statistic)
    return {"what": what, "found": found, "cells": int(known.sum()), "holds": ""}


def _cells(rollouts: pd.DataFrame, policies: pd.DataFrame) -> pd.DataFrame:
    """One row a cell: means of ln E and feedback gain, jitter beyond simulation, the study's E."""
    shaking = rollouts[["jitter_failure", "jitter_failure_sim"]].astype(float)
    excess = (
        rollouts[["kp", "kd"]]
        .assign(excess=shaking.jitter_failure - shaking.jitter_failure_sim)
        .groupby(["kp", "kd"], as_index=False).mean()
    )  # fmt: skip
    means = policies.groupby(["kp", "kd"], as_index=False)[["log", "feedback_gain"]].mean()
    return means.merge(excess, on=["kp", "kd"]).merge(errors(), on=["kp", "kd"], how="left")
