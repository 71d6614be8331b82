import numpy as np
import pytest
import statsmodels.api as sm

from t2l.stats.slopes import log_slopes, share_slopes

KP, KD = (a.ravel() for a in np.meshgrid([32, 128, 512, 2048], [2, 8, 32, 128]))


def _successes(noise):
    draw = np.random.default_rng(0)
    odds = -0.3 * (np.log2(KP) - 8) + 0.4 * (np.log2(KD) - 4) + draw.normal(0, noise, len(KP))
    return draw.binomial(100, 1 / (1 + np.exp(-odds)))


def test_coefficients_are_those_of_a_regression_over_rollouts():
    won = _successes(0.0)
    found = share_slopes(KP, KD, won, np.full(len(won), 100))
    success = np.concatenate([np.arange(100) < w for w in won])
    gains = np.log2(np.column_stack([np.repeat(KP, 100), np.repeat(KD, 100)]))
    rollouts = sm.Logit(success, sm.add_constant(gains)).fit(disp=False)
    assert (found.kp, found.kd) == pytest.approx(tuple(rollouts.params[1:]), abs=1e-6)
    assert found.freedom == 13
    # never narrower than binomial
    assert found.kp_error >= rollouts.bse[1] * 0.999


def test_cells_that_scatter_widen_the_errors():
    trials = np.full(len(KP), 100)
    calm, wild = (share_slopes(KP, KD, _successes(s), trials) for s in (0.0, 1.5))
    assert wild.kp_error > 2 * calm.kp_error
    # more rollouts of the same cells change nothing
    more = share_slopes(KP, KD, 10 * _successes(1.5), 10 * trials)
    assert more.kp_error == pytest.approx(wild.kp_error, rel=1e-6)


def test_slopes_of_logarithms_are_recovered():
    values = np.exp(0.5 * np.log2(KP) - 0.2 * np.log2(KD))
    found = log_slopes(KP, KD, values * np.exp(np.random.default_rng(0).normal(0, 0.01, len(KP))))
    assert (found.kp, found.kd) == pytest.approx((0.5, -0.2), abs=0.02)


@pytest.mark.parametrize("won", [0, 100])
def test_what_cells_do_not_determine_is_not_a_number(won):
    assert np.isnan(share_slopes(KP, KD, np.full(16, won), np.full(16, 100)).kp)
    assert np.isnan(log_slopes(KP[:4], np.ones(4), np.arange(1.0, 5.0)).kp)
    assert log_slopes([1, 2, 4], [1, 2, 1], [1, 2, 3]).freedom == 0


def test_gains_that_separate_success_have_no_slope():
    won = np.where(KD > 16, 100, 0)
    assert np.isnan(share_slopes(KP, KD, won, np.full(16, 100)).kd)
