"""How well what is known before training ranks the cells of tasks, beside what is known after.

The rule: a task is the unit, for cells of one grid are neighbours. In each task every number has
Spearman's ρ with success over its cells, counted with the sign that theory gives it. The predicted
error tells more than a rival if its count is the greater over tasks: one-sided sign-flip test of
the differences, corrected for two rivals, Kd/Kp and the effective error. The interval of their mean
is a bootstrap over tasks.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from t2l.advise.beforehand import forecast, matrices
from t2l.names import heading
from t2l.stats.bootstrap import bootstrap_interval, mean
from t2l.stats.rank import rank_correlations, spearman
from t2l.stats.text import interval, p_value
from t2l.stats.verdict import paired_greater
from t2l.study.attenuation.success import predictors

# and whether success is to rise (+1) or to fall (−1) with each; the last is known after training
SIGNS = {
    "predicted_error": -1, "label_difficulty": -1, "injection": -1, "contraction": -1,
    "amplification": -1, "damping_over_stiffness": +1, "effective_error": -1,
}  # fmt: skip
RIVALS = ("damping_over_stiffness", "effective_error")
NAMES = {
    "predicted_error": "predicted error", "label_difficulty": "label difficulty",
    "injection": "injection", "contraction": "contraction", "amplification": "amplification",
    "damping_over_stiffness": "Kd / Kp", "effective_error": "effective error, after training",
}  # fmt: skip
ALL = "mean over tasks"


def beforehand_table(
    grids: Mapping[str, pd.DataFrame], kept: pd.DataFrame, timestep_s: float, hold_s: float
) -> pd.DataFrame:
    """One row a task and number, then one a number over tasks.

    Args:
        grids: by task, one row a cell: kp, kd, success, loss.
        kept: one row a task and joint: inertia_kg_m2 and `beforehand.RESIDUALS`.

    Returns:
        task, predictor, expected sign, ρ with its 95 % interval over `n` cells, and `rho_loss`,
        that with the validation loss, which label difficulty is to foretell; `factor` and
        `factor_loss`, the greatest over the least of both over cells; `over_loss`, the median of
        the number over the loss. Over tasks: the mean
        of expected · ρ, its interval, `n` tasks, and by how much the predicted error's is greater,
        `more`, `more_low`, `more_high`, `p`, of rivals alone.
    """
    rows = []
    for task, cells in grids.items():
        joints = kept[kept.task == task]
        inertia, c = joints.inertia_kg_m2.to_numpy(), matrices(joints)
        steps = round(hold_s / timestep_s)
        told = pd.DataFrame(
            [
                forecast(kp, kd, inertia, c, timestep_s, steps)
                for kp, kd in zip(cells.kp, cells.kd, strict=True)
            ],
            index=cells.index,
        )
        every = predictors(cells, hold_s).join(told)
        found, _ = rank_correlations(
            {name: every[name].to_numpy() for name in SIGNS}, every.success.to_numpy()
        )
        rows += [
            {"task": task, "predictor": name, "expected": SIGNS[name], "rho": one.rho,
             "low": one.low, "high": one.high, "n": one.cells,
             "rho_loss": float(spearman(every[name].to_numpy(), every.loss.to_numpy())),
             "factor": every[name].max() / every[name].min(),
             "factor_loss": every.loss.max() / every.loss.min(),
             "over_loss": (every[name] / every.loss).median()}
            for name, one in found.items()
        ]  # fmt: skip
    table = pd.DataFrame(rows)
    return pd.concat([table, over_tasks(table)], ignore_index=True)


def over_tasks(table: pd.DataFrame) -> pd.DataFrame:
    """The rows over tasks of a table of one row a task and predictor."""
    signed = table.assign(strength=table.expected * table.rho).pivot(
        index="task", columns="predictor", values="strength"
    )
    rows = []
    for name, sign in SIGNS.items():
        strength = signed[name].to_numpy()
        low, high = bootstrap_interval(mean, strength)
        row = {"task": ALL, "predictor": name, "expected": sign, "rho": strength.mean(),
               "low": low, "high": high, "n": len(strength)}  # fmt: skip
        if name in RIVALS:
            more = (signed.predicted_error - signed[name]).to_numpy()
            found = paired_greater(more, tests=len(RIVALS))
            row |= {"more": found.value, "more_low": found.lower, "more_high": found.upper,
                    "p": found.p}  # fmt: skip
        rows.append(row)
    return pd.DataFrame(rows)


def printable_beforehand(table: pd.DataFrame) -> pd.DataFrame:
    """One row a number, one column a task."""
    shown = {"Known of a cell": [NAMES[name] for name in SIGNS]}
    for task, rows in table.groupby("task", sort=False):
        by_name = rows.set_index("predictor").loc[list(SIGNS)]
        over = task == ALL
        shown[ALL if over else heading(task)] = [
            interval(*row) if over else f"{row[0]:+.2f}"
            for row in zip(by_name.rho, by_name.low, by_name.high, strict=True)
        ]
        if over:
            shown["predicted error tells more by"] = [
                "" if np.isnan(row[0]) else f"{interval(*row[:3])}, p {p_value(row[3])}"
                for row in zip(
                    by_name.more, by_name.more_low, by_name.more_high, by_name.p, strict=True
                )
            ]
    return pd.DataFrame(shown)
