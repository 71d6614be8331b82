from itertools import permutations
from math import isnan

import numpy as np
import pytest
from scipy.stats import mannwhitneyu, spearmanr

from t2l.stats.attainable import (
    bonferroni,
    least_attainable_p,
    least_rank_p,
    least_sign_p,
    reportable,
)


@pytest.mark.parametrize(("inside", "outside"), [(1, 4), (2, 2), (6, 6), (4, 12)])
def test_the_best_separation_of_two_groups_gives_the_least_p(inside, outside):
    high, low = range(100, 100 + inside), range(outside)
    p = mannwhitneyu(high, low, alternative="greater", method="exact").pvalue
    assert least_attainable_p(inside, outside) == pytest.approx(p)


def test_designs_known_by_hand():
    assert least_attainable_p(1, 4) == 0.2
    assert least_attainable_p(1, 4, tests=6) == 1.0
    assert least_attainable_p(6, 6) == 1 / 924
    # a group without units compares nothing
    assert least_attainable_p(0, 7) == least_attainable_p(7, 0) == 1.0
    assert least_sign_p(3) == 1 / 8


def test_of_all_orders_one_is_perfect():
    perfect = sum(spearmanr(range(4), order).statistic > 0.999 for order in permutations(range(4)))
    assert least_rank_p(4) == perfect / 24


def test_no_design_has_no_p():
    with pytest.raises(ValueError, match="no design"):
        least_attainable_p(-1, 4)
    with pytest.raises(ValueError, match="no design"):
        least_attainable_p(1, 4, tests=0)


def test_what_could_not_be_significant_is_not_reported():
    assert reportable(0.3, least=0.01, alpha=0.05) == 0.3
    assert isnan(reportable(0.2, least=0.2, alpha=0.05))


def test_bonferroni_multiplies_and_stops_at_one():
    assert bonferroni(0.01, 5) == pytest.approx(0.05)
    assert bonferroni(0.4, 5) == 1.0
    assert np.isnan(bonferroni(np.nan, 5))
