"""Every rule against planted numbers that must come out each way."""

from math import isnan

import numpy as np
import pytest

from t2l.stats.bootstrap import bootstrap_interval, mean, ratio
from t2l.stats.verdict import (
    Finding,
    Verdict,
    correlated,
    differ,
    every,
    every_at_most,
    greater,
    no_common_winner,
    paired_greater,
    shares_at_least,
    signed,
    within,
)

YES, NO = Verdict.REPRODUCED, Verdict.NOT_REPRODUCED
OPEN = Verdict.CANNOT_TELL
LOW, HIGH = np.arange(12) / 20, np.arange(12, 16) / 20


def test_a_group_that_is_greater_and_one_that_is_not():
    found = greater(HIGH, LOW)
    assert found.verdict is YES
    assert found.p == pytest.approx(1 / 1820)
    assert found.value == pytest.approx(HIGH.mean() - LOW.mean())
    assert found.lower < found.value < found.upper
    assert found.n == 16
    assert greater(LOW[:4], np.concatenate([LOW[4:], HIGH])).verdict is NO


def test_one_unit_against_four_cannot_tell_and_prints_no_p():
    found = greater(np.array([9.0]), np.arange(4.0))
    assert found.verdict is OPEN
    assert isnan(found.p)
    assert greater(np.array([]), LOW).verdict is OPEN


def test_a_correction_may_take_the_decision_away():
    # 1 / C(8, 4) = 0.014, times six 0.086
    assert greater(HIGH, LOW[:4]).verdict is YES
    assert greater(HIGH, LOW[:4], tests=6).verdict is OPEN


def test_what_reaches_the_study_s_number_is_not_refuted():
    draw = np.random.default_rng(3)
    wide, narrow = draw.normal(0, 1, 20), draw.normal(0, 0.01, 20)
    # 0.5 lies within the interval of a difference of ten and ten wide ones, not of narrow ones
    assert greater(wide[:10], wide[10:], claimed=0.5).verdict is OPEN
    assert greater(wide[:10], wide[10:], claimed=0.5).p > 0.05
    assert greater(narrow[:10], narrow[10:], claimed=0.5).verdict is NO
    assert greater(wide[:10], wide[10:]).verdict is NO
    assert signed(0.1, 0.1, 10, +1, 13, claimed=0.3).verdict is OPEN
    assert signed(0.1, 0.1, 10, +1, 13, claimed=0.5).verdict is NO
    assert signed(-0.1, 0.1, 10, -1, 13, claimed=-0.3).verdict is OPEN
    assert signed(0.5, 0.1, 10, -1, 13, claimed=-0.3).verdict is NO


def test_differences_within_units():
    assert paired_greater(np.array([0.1, 0.2, 0.3, 0.1, 0.4])).verdict is YES
    assert paired_greater(np.array([0.1, -0.2, 0.3, -0.1, 0.0])).verdict is NO
    # 2⁻⁴ = 0.0625
    assert paired_greater(np.ones(4)).verdict is OPEN


def test_a_correlation_has_a_sign():
    x = np.arange(10.0)
    assert correlated(x, x**2, +1).verdict is YES
    assert correlated(x, x**2, -1).verdict is NO
    assert correlated(x[:3], x[:3], +1).verdict is OPEN
    assert correlated(x, np.ones(10), +1).verdict is OPEN


def test_a_slope_has_a_sign():
    found = signed(0.5, 0.1, freedom=10, sign=+1, n=13)
    assert found.verdict is YES
    # t(10) is 2.228 at 97.5 %
    assert (found.lower, found.upper) == pytest.approx((0.277, 0.723), abs=1e-3)
    assert signed(0.5, 0.1, 10, -1, 13).verdict is NO
    assert signed(0.1, 0.1, 10, +1, 13).verdict is NO
    assert signed(0.5, 0.1, 2, +1, 5).verdict is OPEN
    assert signed(float("nan"), float("nan"), 10, +1, 13).verdict is OPEN


def test_a_number_lies_between_bounds_or_not_or_it_is_open():
    values = np.array([1.0, 1.1, 0.9, 1.05, 0.95])
    assert within(mean, values, low=0.5, high=1.5).verdict is YES
    assert within(mean, values, low=2.0).verdict is NO
    assert within(mean, values, high=0.5).verdict is NO
    assert within(mean, values, high=1.0).verdict is OPEN
    # the lowest of three comes three times with 1/27 > 2.5 %, the lowest of four with 1/256
    assert within(mean, values[:3], low=0.5).verdict is OPEN
    assert within(mean, values[:4], low=0.5).verdict is YES
    # two units show no spread, however many others there are
    assert within(ratio, values[:2], values, low=0.5).verdict is OPEN
    assert within(ratio, 10 * values, values, low=9, high=11).value == pytest.approx(10)


def test_shares_reach_a_bound_as_the_study_counts():
    assert shares_at_least([100, 99], [100, 100], 0.99).verdict is YES
    # 98 of 100: the interval reaches 99.4 %
    assert shares_at_least([100, 98], [100, 100], 0.99).verdict is OPEN
    found = shares_at_least([100, 93], [100, 100], 0.99)
    assert (found.verdict, found.value) == (NO, 0.93)


def test_exact_numbers_need_no_interval():
    assert every_at_most([0.01, 0.1], 0.1).verdict is YES
    assert every_at_most([0.01, 0.11], 0.1).verdict is NO


def test_groups_of_trials_differ():
    # the study's own: 32, 8, 10, 4 of 50
    assert differ([32, 8, 10, 4], [50] * 4).verdict is YES
    assert differ([20, 21, 19, 20], [50] * 4).verdict is NO
    assert differ([0, 0, 0, 0], [50] * 4).verdict is NO
    assert differ([1, 0, 1, 1], [1] * 4).verdict is OPEN


def test_a_common_winner():
    assert no_common_winner(["CO", "SU"], 4).verdict is YES
    # 4⁻¹ is no evidence, 4⁻³ is
    assert no_common_winner(["CO", "CO"], 4).verdict is OPEN
    assert no_common_winner(["CO"] * 4, 4).verdict is NO
    assert no_common_winner(["CO"], 4).verdict is OPEN


def test_all_of_several_claims():
    yes, no, open_ = Finding(YES, 5, p=0.01), Finding(NO, 5, p=0.4), Finding(OPEN, 5)
    assert every([yes, yes]).verdict is YES
    assert every([yes, no]).verdict is NO
    assert every([yes, no]).p == 0.4
    assert every([yes, open_]).verdict is OPEN
    assert isnan(every([yes, open_]).p)
    assert every([open_, no]).verdict is NO


def test_an_interval_covers_the_mean_as_often_as_it_says():
    draw = np.random.default_rng(0)
    covered = 0
    for _ in range(200):
        low, high = bootstrap_interval(mean, draw.normal(0, 1, 30))
        covered += low <= 0 <= high
    # the percentile method is a little short of 95 %
    assert 0.89 < covered / 200 < 0.98
