"""How often policies succeed that were learned in simulation alone.

A policy is one replication of its cell. Its share of episodes has Wilson's interval, which is about
this policy and not about the cell; the study's threshold of existence is 99 % (section V-B).
"""

import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from t2l.names import heading
from t2l.rl.alone import COLUMNS
from t2l.stats.text import rate

# the study's: a policy exists where one succeeds this often
EXISTS = 0.99
TRIAL_COLUMNS = ("task", "kp", "kd", "number", "state", "success")
HEADERS: dict[str, str] = {"Kp": "$K_p$", "Kd": "$K_d$"}


def learning_table(policies: pd.DataFrame) -> pd.DataFrame:
    """One row a policy, columns `COLUMNS`, success, success_low, success_high and exists.

    Args:
        policies: columns `COLUMNS`.
    """
    policies = policies[list(COLUMNS)]
    table = policies.sort_values(["task", "kp", "kd", "seed"], ignore_index=True)
    low, high = proportion_confint(table.successes, table.episodes, method="wilson")
    share = table.successes / table.episodes
    return table.assign(
        success=share, success_low=low, success_high=high, exists=share >= EXISTS
    )  # fmt: skip


def printable(table: pd.DataFrame) -> pd.DataFrame:
    """The table as text."""
    spans = zip(table.success, table.success_low, table.success_high, strict=True)
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Kp": [f"{kp:g}" for kp in table.kp],
            "Kd": [f"{kd:g}" for kd in table.kd],
            "Policy": table.seed.astype(str),
            "Fresh episodes": table.episodes.astype(str),
            "Success": [f"{rate(s)} ({100 * a:.0f} to {100 * b:.0f})" for s, a, b in spans],
            "At least 99 %": ["yes" if exists else "no" for exists in table.exists],
            "Ended early": [rate(share) for share in table.failed],
            "Jitter": [rate(share) for share in table.jitter],
            "Steps [million]": [f"{steps / 1e6:.2f}" for steps in table.steps],
            "Minutes": [f"{seconds / 60:.0f}" for seconds in table.seconds],
        }
    )


def trials_table(trials: pd.DataFrame, passed: float) -> pd.DataFrame:
    """One row a cell: its trials, those that were completed, those that passed, and the best.

    Args:
        trials: columns `TRIAL_COLUMNS`.
        passed: success that a trial which passes is above.
    """
    complete = trials.state == "complete"
    told = trials.assign(
        trials=1, completed=complete, passed=complete & (trials.success > passed),
        best_success=trials.success.where(complete),
    )  # fmt: skip
    sums = {"trials": "sum", "completed": "sum", "passed": "sum", "best_success": "max"}
    return told.groupby(["task", "kp", "kd"], as_index=False).agg(sums)


def printable_trials(table: pd.DataFrame) -> pd.DataFrame:
    """The table as text."""
    return pd.DataFrame(
        {
            "Task": [heading(name) for name in table.task],
            "Kp": [f"{kp:g}" for kp in table.kp],
            "Kd": [f"{kd:g}" for kd in table.kd],
            "Trials": table.trials.astype(str),
            "Completed": table.completed.astype(str),
            "Passed": table.passed.astype(str),
            "Best success": [rate(share) for share in table.best_success],
        }
    )
