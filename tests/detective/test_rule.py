"""The rule where an effect acts in one place only, so that resampled blocks often lack it."""

import numpy as np

from t2l.detective.choosing import as_good
from t2l.detective.fitted_set import FittedSet
from t2l.detective.rule import Judge
from t2l.effects.term import Layout

NOISE_RAD = 1e-4
BLOCKS, OF_BLOCK = 40, 25


def leaving(residual: np.ndarray) -> FittedSet:
    n = len(residual)
    nothing = np.zeros(0)
    told, jacobian = np.ones(n, bool), np.zeros((n, 0))
    return FittedSet(Layout([]), nothing, residual, residual, told, jacobian, nothing.astype(bool))


def in_one_block(noise: np.ndarray, rmse_rad: float) -> np.ndarray:
    """The noise, and in one block what makes it so much in all."""
    more = np.sqrt((rmse_rad**2 - np.mean(noise**2)) * BLOCKS)
    return noise + np.where(np.arange(len(noise)) < OF_BLOCK, more, 0.0) * np.sign(noise)


def test_what_leaves_noise_alone_is_not_given_up_for_what_leaves_more():
    rng = np.random.default_rng(0)
    noise = NOISE_RAD * rng.standard_normal(BLOCKS * OF_BLOCK)
    judge = Judge(np.repeat(np.arange(BLOCKS), OF_BLOCK), NOISE_RAD)
    whole, fewer = leaving(noise), leaving(in_one_block(noise, 1.3 * NOISE_RAD))
    # a bootstrap alone would let it go
    assert not judge.earns(fewer, whole)
    assert judge.misses(whole, fewer)
    # nothing tells a difference within the noise, nor of as much where more than noise is left
    assert not judge.misses(whole, leaving(in_one_block(noise, 1.15 * NOISE_RAD)))
    worse = leaving(3 * noise), leaving(in_one_block(3 * noise, 3.9 * NOISE_RAD))
    assert not judge.misses(*worse)


def test_no_exchange_beside_noise_for_what_leaves_more_in_one_place():
    rng = np.random.default_rng(0)
    noise = NOISE_RAD * rng.standard_normal(BLOCKS * OF_BLOCK)
    judge = Judge(np.repeat(np.arange(BLOCKS), OF_BLOCK), NOISE_RAD)
    whole, worse, as_near = (
        leaving(in_one_block(noise, times * NOISE_RAD)) for times in (1.01, 1.15, 1.05)
    )
    # the rule alone would take either, if it had fewer numbers
    assert not judge.misses(whole, worse)
    assert as_good(whole, [worse, as_near], judge) == [as_near]
