"""The rule where an effect acts in one place only, so that resampled blocks often lack it."""

import numpy as np
import pytest

from t2l.detective.fitted_set import FittedSet
from t2l.detective.rule import Judge
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term

NOISE_RAD = 1e-4
BLOCKS, OF_BLOCK = 40, 25


def leaving(residual: np.ndarray, names: tuple[str, ...] = ()) -> FittedSet:
    layout = Layout([Term(builtin()[name], (0,)) for name in names])
    n, k = len(residual), len(layout)
    jacobian = np.random.default_rng(1).standard_normal((n, k))
    told, free = np.ones(n, bool), np.ones(k, bool)
    return FittedSet(layout, np.zeros(k), residual, residual, told, jacobian, free)


def in_one_block(noise: np.ndarray, rmse_rad: float) -> np.ndarray:
    """The noise, and in one block what makes it so much in all."""
    more = np.sqrt((rmse_rad**2 - np.mean(noise**2)) * BLOCKS)
    return noise + np.where(np.arange(len(noise)) < OF_BLOCK, more, 0.0) * np.sign(noise)


def cases(times: float, first: float, *others: float) -> tuple[Judge, list[FittedSet]]:
    """Sets that leave so many times an error: one, and of fewer numbers others."""
    rng = np.random.default_rng(0)
    noise = times * NOISE_RAD * rng.standard_normal(BLOCKS * OF_BLOCK)
    judge = Judge(np.repeat(np.arange(BLOCKS), OF_BLOCK), NOISE_RAD)
    left = [in_one_block(noise, more * times * NOISE_RAD) for more in (first, *others)]
    return judge, [leaving(left[0], ("torque_offset",)), *map(leaving, left[1:])]


@pytest.mark.parametrize("times", [1.0, 3.0])
def test_no_smaller_set_takes_the_place_of_what_leaves_less_in_one_place(times):
    judge, (whole, fewer, as_near) = cases(times, 1.01, 1.3, 1.08)
    # a bootstrap alone would let it go
    assert not judge.earns(fewer, whole)
    assert not judge.takes(whole, fewer)
    assert judge.takes(whole, as_near)


def test_a_term_is_missed_where_noise_alone_was_left():
    judge, (whole, fewer, as_near) = cases(1.0, 1.01, 1.3, 1.15)
    assert judge.misses(whole, fewer)
    # nothing tells a difference within the noise, nor of as much where more than noise is left
    assert not judge.misses(whole, as_near)
    judge, (whole, fewer) = cases(3.0, 1.01, 1.3)
    assert not judge.misses(whole, fewer)
