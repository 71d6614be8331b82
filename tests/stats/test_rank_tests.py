import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from t2l.stats.rank import spearman
from t2l.stats.rank_tests import rank_correlation, rank_sum_p, sign_flip_p


def test_ranks_of_two_groups_by_hand():
    # of the 6 ways to choose two of four ranks, one sums to 7 and one to 6
    assert rank_sum_p([3, 4], [1, 2]) == pytest.approx(1 / 6)
    assert rank_sum_p([2, 4], [1, 3]) == pytest.approx(2 / 6)
    assert rank_sum_p([5], [1, 2, 3, 4]) == pytest.approx(1 / 5)
    assert np.isnan(rank_sum_p([], [1.0]))


def test_ties_share_their_ranks():
    # all equal: every arrangement is as good
    assert rank_sum_p([1, 1], [1, 1]) == 1.0
    # ranks 1, 2.5, 2.5, 4: {2.5, 4} sums to 6.5, which two of six arrangements reach
    assert rank_sum_p([2, 3], [1, 2]) == pytest.approx(2 / 6)


def test_enumeration_agrees_with_scipy_where_there_are_no_ties():
    draw = np.random.default_rng(1)
    a, b = draw.normal(0.5, 1, 6), draw.normal(0, 1, 6)
    assert rank_sum_p(a, b) == pytest.approx(
        mannwhitneyu(a, b, alternative="greater", method="exact").pvalue
    )


def test_signs_by_hand():
    # of 8 patterns of signs, one has the mean of [1, 2, 3] or more
    assert sign_flip_p(np.array([1.0, 2.0, 3.0])) == pytest.approx(1 / 8)
    # + − − − and all plus: [3, -1, -1] sums to 1, reached by 3±… patterns: 3 and 5
    assert sign_flip_p(np.array([3.0, -1.0, -1.0])) == pytest.approx(4 / 8)
    assert sign_flip_p(np.array([1.0])) == 0.5
    assert np.isnan(sign_flip_p(np.array([])))


def test_rank_correlation_by_hand():
    # ρ = 1 − 6 Σd² / (n (n² − 1)), with d = (0, 1, −1, 0)
    rho, p = rank_correlation([1, 2, 3, 4], [10, 30, 20, 40], +1)
    assert rho == pytest.approx(1 - 6 * 2 / (4 * 15))
    # of 24 orders, one has ρ = 1 and three have Σd² = 2
    assert p == pytest.approx(4 / 24)
    assert rank_correlation([1, 2, 3, 4], [10, 30, 20, 40], -1)[1] == pytest.approx(23 / 24)
    assert np.isnan(rank_correlation([1, 1, 1], [1, 2, 3], +1)[0])


def test_spearman_goes_along_the_last_axis():
    x = np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    y = np.array([[1.0, 5.0, 9.0], [1.0, 5.0, 9.0]])
    assert spearman(x, y).tolist() == [1.0, -1.0]


def test_equal_numbers_that_rounding_tells_apart_are_ties():
    apart, others = [0.3 - 0.1, 0.5, 0.0], [0.4 - 0.2, 0.2, 0.1 + 0.2 - 0.3, 0.0]
    assert apart[0] != others[1]
    assert others[2] != others[3]
    exact, same = [0.2, 0.5, 0.0], [0.2, 0.2, 0.0, 0.0]
    assert rank_sum_p(apart, others) == rank_sum_p(exact, same)
    many = 8  # of each: more arrangements than are counted
    assert rank_sum_p(apart * many, others * many) == rank_sum_p(exact * many, same * many)
    x, known, y = np.array([*apart, *others]), np.array([*exact, *same]), np.arange(7.0)
    assert spearman(x, y) == spearman(known, y)
    assert rank_correlation(x, y, 1) == rank_correlation(known, y, 1)


def test_small_numbers_are_no_ties():
    assert rank_sum_p([3e-9, 4e-9, 1.0], [1e-9, 2e-9, 1e-10]) == pytest.approx(1 / 20)
