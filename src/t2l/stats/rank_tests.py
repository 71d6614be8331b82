"""One-sided tests by ranks and signs, exact where the arrangements can be counted.

Approximations for large samples may give a p below the least that the design attains, for example
with one unit against four. So what is small is enumerated.
"""

from itertools import combinations
from math import comb, factorial, nan

import numpy as np
from scipy.stats import mannwhitneyu, permutation_test, rankdata, spearmanr

from t2l.stats.rank import spearman, without_rounding

MOST_ARRANGEMENTS = 20_000  # enumerated in well under a second


def rank_sum_p(values: np.ndarray, others: np.ndarray) -> float:
    """Of the Mann-Whitney U test that `values` tend to be the greater; NaN without either."""
    values, others = np.asarray(values, float), np.asarray(others, float)
    if not len(values) or not len(others):
        return nan
    n, inside = len(values) + len(others), len(values)
    both = without_rounding(np.concatenate([values, others]))
    if comb(n, inside) > MOST_ARRANGEMENTS:
        return float(mannwhitneyu(both[:inside], both[inside:], alternative="greater").pvalue)
    ranks = rankdata(both)
    sums = ranks[np.array(list(combinations(range(n), inside)))].sum(axis=1)
    # ranks are multiples of a half
    return float((sums >= ranks[:inside].sum() - 0.25).mean())


def sign_flip_p(differences: np.ndarray) -> float:
    """Of the permutation test that paired differences have a mean above zero; NaN without any."""
    differences = np.asarray(differences, float)
    if len(differences) < 2:
        return 0.5 if (differences > 0).any() else (1.0 if len(differences) else nan)
    found = permutation_test(
        (differences,),
        lambda d, axis: np.mean(d, axis=axis),
        permutation_type="samples",
        alternative="greater",
        n_resamples=MOST_ARRANGEMENTS,
        rng=np.random.default_rng(0),
    )
    return float(found.pvalue)


def rank_correlation(x: np.ndarray, y: np.ndarray, sign: int) -> tuple[float, float]:
    """Spearman's ρ, and the one-sided p that it has the sign; NaN where it is not defined."""
    alternative = "greater" if sign > 0 else "less"
    if len(x) < 3 or np.ptp(x) == 0 or np.ptp(y) == 0:
        return nan, nan
    x, y = without_rounding(x), without_rounding(y)
    found = spearmanr(x, y, alternative=alternative)
    if factorial(min(len(x), 20)) > MOST_ARRANGEMENTS:
        return float(found.statistic), float(found.pvalue)
    exact = permutation_test(
        (x,),
        lambda x, axis: spearman(x, np.broadcast_to(y, np.shape(x))),
        permutation_type="pairings",
        alternative=alternative,
        n_resamples=MOST_ARRANGEMENTS,
    )
    return float(found.statistic), float(exact.pvalue)
