"""The smallest p value that a design can give, whatever the data: to be known before a run.

A one-sided permutation test of n units compares one arrangement with all others that would have
been as likely. Its p is a number of arrangements over their count, so it is never below one over
that count. Where that is above the level α, the test decides nothing, and no p is to be printed.
"""

from math import comb, factorial, isnan, nan

import numpy as np


def least_attainable_p(n_inside: int, n_outside: int, tests: int = 1) -> float:
    """Of a one-sided permutation or Mann-Whitney test between two groups: 1 / C(n, n_inside).

    Args:
        n_inside, n_outside: units of replication (cells, not rollouts) in each group.
        tests: what p is corrected for (Bonferroni).

    Raises:
        ValueError: a count is negative, or `tests` is not positive.
    """
    if min(n_inside, n_outside) < 0 or tests < 1:
        raise ValueError(f"{n_inside} and {n_outside} units in {tests} tests are no design")
    return min(1.0, tests / comb(n_inside + n_outside, n_inside))


def least_rank_p(n: int, tests: int = 1) -> float:
    """Of a one-sided test of a rank correlation between n pairs: 1 / n!."""
    return min(1.0, tests / factorial(n))


def least_sign_p(n: int, tests: int = 1) -> float:
    """Of a one-sided sign or sign-flip test of n paired differences: 2⁻ⁿ."""
    return min(1.0, tests / 2**n)


def bonferroni(p: float, tests: int) -> float:
    """A p value corrected for `tests` tests; NaN stays NaN."""
    return float(np.minimum(1.0, p * tests))


def reportable(p: float, least: float, alpha: float) -> float:
    """The p value, or NaN where the design could not have given one of at most α."""
    return nan if isnan(p) or least > alpha else p
