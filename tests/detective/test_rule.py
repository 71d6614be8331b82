"""The rule where an effect acts in one place only, so that resampled blocks often lack it."""

import numpy as np
import pytest

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


@pytest.mark.parametrize("times", [1.0, 3.0])
def test_what_is_less_is_not_given_up_for_what_leaves_more_in_one_place(times):
    rng = np.random.default_rng(0)
    noise = times * NOISE_RAD * rng.standard_normal(BLOCKS * OF_BLOCK)
    judge = Judge(np.repeat(np.arange(BLOCKS), OF_BLOCK), NOISE_RAD)
    whole, fewer, as_near = (
        leaving(in_one_block(noise, more * times * NOISE_RAD)) for more in (1.01, 1.3, 1.08)
    )
    # a bootstrap alone would let it go
    assert not judge.earns(fewer, whole)
    assert judge.misses(whole, fewer)
    assert not judge.misses(whole, as_near)
