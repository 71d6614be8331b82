"""Residuals of what was left out are those of fits without it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.propose.cross_validation import left_out


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(2, 6))
def test_a_linear_fit_without_each_block_is_the_same(seed, parameters, count):
    rng = np.random.default_rng(seed)
    # units of any size
    columns = rng.normal(size=(60, parameters)) * 10.0 ** rng.integers(-4, 5, parameters)
    measured, block = rng.normal(size=60), rng.integers(0, count, 60)
    weights = np.linalg.lstsq(columns, measured, rcond=None)[0]
    found = left_out(columns, columns @ weights - measured, block)
    for number in np.unique(block):
        at = block == number
        others = np.linalg.lstsq(columns[~at], measured[~at], rcond=None)[0]
        assert found[at] == pytest.approx(columns[at] @ others - measured[at], abs=1e-4)


def test_what_no_residual_shows_changes_nothing():
    columns = np.stack([np.ones(6), np.zeros(6)], axis=1)
    found = left_out(columns, np.array([1.0, -1, 1, -1, 1, -1]), np.arange(6) // 2)
    assert found == pytest.approx([1.0, -1, 1, -1, 1, -1])
