"""Rules that turn numbers of independent units into a verdict about a claim.

Each rule first asks whether the design can decide at all: if not, `cannot be told`, and no p. A
test that does not reject leaves the claim `not reproduced`, unless the 95 % interval reaches what
the study claims: then the data agree with it as well as with nothing, and it cannot be told.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf, isnan, nan

import numpy as np
from scipy.stats import chi2_contingency, t
from statsmodels.stats.proportion import proportion_confint

from t2l.stats.attainable import (
    bonferroni,
    least_attainable_p,
    least_rank_p,
    least_sign_p,
    reportable,
)
from t2l.stats.bootstrap import bootstrap_interval, difference, mean
from t2l.stats.rank import spearman
from t2l.stats.rank_tests import rank_correlation, rank_sum_p, sign_flip_p

ALPHA = 0.05
LEAST_ABOVE_ZERO = 1e-9  # numerics: equal numbers leave a rounding error
FEWEST_FREEDOM = 3  # degrees of freedom: below, Student's t asks for more than four errors


class Verdict(StrEnum):
    """What can be said about a claim."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    CANNOT_TELL = "cannot be told"
    NOT_RUN = "not run"


@dataclass(frozen=True)
class Finding:
    """What a rule came to.

    Attributes:
        n: units of replication.
        value: the effect that the rule judged, with its 95 % interval; NaN where there is none.
        p: corrected; NaN where none was computed, or where the least attainable exceeds α.
        ours: our numbers as a person reads them.
        results: whose they are, a folder below results/; empty where they are of several.
        unit: of replication, where it is another than the claim names.
    """

    verdict: Verdict
    n: int = 0
    value: float = nan
    lower: float = nan
    upper: float = nan
    p: float = nan
    ours: str = ""
    results: str = ""
    unit: str = ""


def greater(
    inside: np.ndarray,
    outside: np.ndarray,
    alpha: float = ALPHA,
    tests: int = 1,
    claimed: float = nan,
    statistic: Callable[..., np.ndarray] = difference,
) -> Finding:
    """Units inside have the greater values: one-sided Mann-Whitney test.

    Args:
        claimed: the size of the effect in the study, where it has one.
        statistic: that size of ours, `value`; its interval is a bootstrap over units.
    """
    least = least_attainable_p(len(inside), len(outside), tests)
    p = bonferroni(rank_sum_p(inside, outside), tests)
    value = statistic(inside, outside) if len(inside) and len(outside) else nan
    interval = bootstrap_interval(statistic, inside, outside)
    return _tested(p, least, alpha, len(inside) + len(outside), value, interval, claimed)


def paired_greater(
    differences: np.ndarray, alpha: float = ALPHA, tests: int = 1, claimed: float = nan
) -> Finding:
    """Differences within units are above zero on average: one-sided sign-flip test."""
    differences = np.asarray(differences, float)
    least = least_sign_p(len(differences), tests)
    p = bonferroni(sign_flip_p(differences), tests)
    value = differences.mean() if len(differences) else nan
    interval = bootstrap_interval(mean, differences)
    return _tested(p, least, alpha, len(differences), value, interval, claimed)


def correlated(
    x: np.ndarray,
    y: np.ndarray,
    sign: int,
    alpha: float = ALPHA,
    tests: int = 1,
    claimed: float = nan,
) -> Finding:
    """Spearman's ρ of units has the claimed sign: one-sided; its interval by bootstrap."""
    rho, p = rank_correlation(x, y, sign)
    interval = bootstrap_interval(spearman, x, y, paired=True)
    p, least = bonferroni(p, tests), least_rank_p(len(x), tests)
    return _tested(p, least, alpha, len(x), rho, interval, claimed, sign)


def signed(
    value: float,
    error: float,
    freedom: int,
    sign: int,
    n: int,
    alpha: float = ALPHA,
    tests: int = 1,
    claimed: float = nan,
) -> Finding:
    """A slope has the claimed sign: one-sided t test with `freedom` degrees of freedom."""
    if freedom < FEWEST_FREEDOM or isnan(value) or not error > 0:
        return Finding(Verdict.CANNOT_TELL, n, value)
    p = bonferroni(float(t.sf(sign * value / error, freedom)), tests)
    half = float(t.ppf(0.975, freedom)) * error
    return _tested(p, 0.0, alpha, n, value, (value - half, value + half), claimed, sign)


def within(
    statistic: Callable[..., np.ndarray],
    *groups: np.ndarray,
    low: float = -inf,
    high: float = inf,
    paired: bool = False,
) -> Finding:
    """A number lies between bounds: reproduced if its whole interval does, not if none of it."""
    groups = tuple(np.asarray(group, float) for group in groups)
    n = len(groups[0]) if paired else sum(map(len, groups))
    lower, upper = bootstrap_interval(statistic, *groups, paired=paired)
    if isnan(lower):
        return Finding(Verdict.CANNOT_TELL, n)
    if low <= lower and upper <= high:
        verdict = Verdict.REPRODUCED
    elif upper < low or high < lower:
        verdict = Verdict.NOT_REPRODUCED
    else:
        verdict = Verdict.CANNOT_TELL
    return Finding(verdict, n, float(statistic(*groups)), lower, upper)


def above_zero(
    statistic: Callable[..., np.ndarray], *groups: np.ndarray, paired: bool = False
) -> Finding:
    """A number is above 0: reproduced if its whole interval is, not if none of it is above 0."""
    return within(statistic, *groups, low=LEAST_ABOVE_ZERO, paired=paired)


def shares_at_least(successes: Sequence[int], trials: Sequence[int], bound: float) -> Finding:
    """Every unit's share reaches a bound, as the study counts.

    Not reproduced where the 95 % Wilson interval of one lies below it. A unit that misses the bound
    by less than that leaves the claim open. `value` is the least share.
    """
    shares = np.asarray(successes) / np.asarray(trials)
    least = int(np.argmin(shares))
    ends = proportion_confint(np.asarray(successes), np.asarray(trials), method="wilson")
    lower, upper = (np.asarray(end) for end in ends)
    if (shares >= bound).all():
        verdict = Verdict.REPRODUCED
    elif (upper < bound).any():
        verdict = Verdict.NOT_REPRODUCED
    else:
        verdict = Verdict.CANNOT_TELL
    return Finding(verdict, len(shares), shares[least], lower[least], upper[least])


def every_at_most(values: np.ndarray, bound: float) -> Finding:
    """Every unit's value is at most a bound: of exact quantities, which need no interval."""
    values = np.asarray(values, float)
    met = bool((values <= bound).all())
    verdict = Verdict.REPRODUCED if met else Verdict.NOT_REPRODUCED
    return Finding(verdict, len(values), float(values.max()))


def differ(successes: Sequence[int], trials: Sequence[int], alpha: float = ALPHA) -> Finding:
    """Groups of trials do not share one rate of success: χ² test of homogeneity.

    Its least p is that of the most unequal table with as many trials: one group succeeds always,
    the others never. `value` is the range of the shares.
    """
    won, all_ = np.asarray(successes), np.asarray(trials)
    n = int(all_.sum())
    if len(won) < 2 or not all_.all():
        return Finding(Verdict.CANNOT_TELL, n)
    extreme = np.where(np.arange(len(all_)) == np.argmax(all_), all_, 0)
    p = 1.0 if won.sum() in (0, n) else _homogeneity(won, all_)
    value = float(np.ptp(won / all_))
    return _tested(p, _homogeneity(extreme, all_), alpha, n, value, (nan, nan))


def no_common_winner(winners: Sequence[str], groups: int, alpha: float = ALPHA) -> Finding:
    """No group is the best in every task: not reproduced if that is unlikely by chance.

    By chance, all of k tasks have the same winner among `groups` with probability groups^(1 − k).
    """
    k = len(winners)
    if k < 2:
        return Finding(Verdict.CANNOT_TELL, k)
    if len(set(winners)) > 1:
        return Finding(Verdict.REPRODUCED, k)
    p = float(groups) ** (1 - k)
    verdict = Verdict.NOT_REPRODUCED if p <= alpha else Verdict.CANNOT_TELL
    return Finding(verdict, k, p=reportable(p, p, alpha))


def every(findings: Sequence[Finding]) -> Finding:
    """All of several claims hold: the greatest p decides (an intersection-union test).

    The number shown is that of the first, the verdict and p those of the weakest.
    """
    order = [
        Verdict.NOT_RUN, Verdict.NOT_REPRODUCED, Verdict.CANNOT_TELL, Verdict.REPRODUCED
    ]  # fmt: skip
    weakest = min(findings, key=lambda finding: order.index(finding.verdict))
    first = findings[0]
    known = weakest.verdict in (Verdict.NOT_REPRODUCED, Verdict.REPRODUCED)
    p = max((one.p for one in findings if known and not isnan(one.p)), default=nan)
    return Finding(weakest.verdict, first.n, first.value, first.lower, first.upper, p)


def _homogeneity(successes: np.ndarray, trials: np.ndarray) -> float:
    return float(chi2_contingency([successes, trials - successes], correction=False).pvalue)


def _tested(
    p: float,
    least: float,
    alpha: float,
    n: int,
    value: float,
    interval: tuple[float, float],
    claimed: float = nan,
    sign: int = 1,
) -> Finding:
    shown = reportable(p, least, alpha)
    reaches = interval[1] >= claimed if sign > 0 else interval[0] <= claimed
    if isnan(shown) or (p > alpha and reaches):
        verdict = Verdict.CANNOT_TELL
    else:
        verdict = Verdict.REPRODUCED if p <= alpha else Verdict.NOT_REPRODUCED
    return Finding(verdict, n, float(value), *interval, shown)
