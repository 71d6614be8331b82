"""Whether one group succeeds more often than another."""

import numpy as np
from scipy.stats import barnard_exact


def barnard_greater(successes: int, trials: int, other_successes: int, other_trials: int) -> float:
    """One-sided p value of Barnard's exact test that the first group's rate is the greater.

    Barnard (1945); Wald statistic with pooled variance, the nuisance rate maximised over.

    Raises:
        ValueError: more successes than trials, or a group without trials.
    """
    for s, n in ((successes, trials), (other_successes, other_trials)):
        if not 0 <= s <= n or n == 0:
            raise ValueError(f"{s} successes of {n} trials are not counts of an experiment")
    table = [
        [successes, other_successes],
        [trials - successes, other_trials - other_successes],
    ]
    return float(barnard_exact(table, alternative="greater").pvalue)


def bonferroni(p: float, tests: int) -> float:
    """A p value corrected for `tests` tests; NaN stays NaN."""
    return float(np.minimum(1.0, p * tests))
