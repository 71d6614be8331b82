"""Weights of a law beside a model are those of a fit of all together."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from t2l.propose.partial_regression import PartialRegression
from t2l.propose.ridge import fit


@given(
    seed=st.integers(0, 2**32 - 1),
    others=st.integers(0, 4),
    own=st.integers(1, 4),
    penalties=st.integers(0, 3),
)
def test_frisch_waugh_lovell(seed, others, own, penalties):
    rng = np.random.default_rng(seed)
    n = 60
    columns, responses, residual = (rng.normal(size=(n, k)) for k in (others, own, 1))
    rows, u = rng.normal(size=(penalties, others)), rng.normal(size=others)
    fitted, chosen = np.arange(n) < 40, np.arange(n) >= 40
    partial = PartialRegression(columns, rows, u, fitted)
    found = fit(
        partial.left_of_responses(responses), partial.left_of(residual[:, 0]),
        *partial.masks(chosen), np.zeros((0, own)),
    )  # fmt: skip
    both = np.block([[columns[fitted], responses[fitted]], [rows, np.zeros((penalties, own))]])
    target = np.concatenate([residual[fitted, 0], -rows @ u])
    change = np.linalg.lstsq(both, target, rcond=None)[0]
    np.testing.assert_allclose(found.weights, change[others:], rtol=1e-5, atol=1e-6)
    left = residual[chosen, 0] - np.hstack([columns, responses])[chosen] @ change
    np.testing.assert_allclose(found.chosen, np.mean(left**2), rtol=1e-5)


def test_what_no_data_touch_stays_and_hides_nothing():
    """As a weight at its bound, whose derivative is zero."""
    n, fitted = 30, np.arange(30) < 20
    residual = np.random.default_rng(0).normal(size=n)
    partial = PartialRegression(np.zeros((n, 1)), np.zeros((0, 1)), np.ones(1), fitted)
    np.testing.assert_array_equal(partial.left_of(residual), residual)
    silent = partial.left_of_responses(np.zeros((n, 3)))
    found = fit(silent, residual, *partial.masks(~fitted), np.diff(np.eye(3), 2, axis=0))
    np.testing.assert_array_equal(found.weights, 0.0)
    np.testing.assert_allclose(found.chosen, np.mean(residual[~fitted] ** 2))
