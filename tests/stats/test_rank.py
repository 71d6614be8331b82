import numpy as np
import pytest
from scipy.stats import spearmanr

from t2l.stats.rank import FEWEST_CELLS, rank_correlations, spearman

RNG = np.random.default_rng(0)


def test_ties_share_their_rank():
    x, y = [1, 2, 2, 3, 5, 8], [2, 1, 4, 4, 4, 6]
    assert spearman(x, y) == pytest.approx(spearmanr(x, y).statistic)


def test_what_does_not_vary_correlates_with_nothing():
    assert np.isnan(spearman([1, 1, 1, 1], [1, 2, 3, 4]))
    assert np.isnan(spearman([1, 2], [1, 2]))


def test_a_planted_trend_is_found_and_its_absence_too():
    outcome = np.linspace(0, 1, 40)
    told = {"planted": -outcome + RNG.normal(0, 0.2, 40), "absent": RNG.normal(size=40)}
    found, stronger = rank_correlations(told, outcome)
    planted, absent = found["planted"], found["absent"]
    assert planted.low < planted.rho < planted.high < -0.5
    assert absent.low < 0 < absent.high
    assert planted.cells == 40
    more, low, _ = stronger["absent"]
    assert more == pytest.approx(abs(planted.rho) - abs(absent.rho))
    assert low > 0


def test_two_that_tell_the_same_are_equally_strong():
    outcome = np.arange(20.0)
    told = {"one": RNG.permutation(20), "other": None}
    told["other"] = -(told["one"] ** 3.0)
    _, stronger = rank_correlations(told, outcome)
    assert stronger["other"] == pytest.approx((0, 0, 0))


def test_too_few_cells_have_no_interval():
    n = FEWEST_CELLS - 1
    found, _ = rank_correlations({"x": np.arange(n)}, np.arange(n))
    assert found["x"].rho == pytest.approx(1)
    assert np.isnan([found["x"].low, found["x"].high]).all()
