from itertools import product
from math import comb

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.stats.barnard import barnard_greater, bonferroni


def test_a_published_table():
    # a vaccine trial, 7 of 15 infected against 12 of 15: p = 0.0341 (Lin and Yang 2009)
    assert barnard_greater(12, 15, 7, 15) == pytest.approx(0.03407, abs=5e-5)


@settings(max_examples=15, deadline=None)
@given(n=st.integers(2, 7), m=st.integers(2, 7), data=st.data())
def test_against_enumeration(n, m, data):
    s, t = data.draw(st.integers(0, n)), data.draw(st.integers(0, m))

    def wald(a, b):
        pooled = (a + b) / (n + m)
        spread = pooled * (1 - pooled) * (1 / n + 1 / m)
        return 0.0 if spread == 0 else (a / n - b / m) / spread**0.5

    def p_value(margin):
        extreme = [
            (a, b)
            for a, b in product(range(n + 1), range(m + 1))
            if wald(a, b) >= wald(s, t) + margin or (a, b) == (s, t)
        ]
        return max(
            sum(
                comb(n, a) * comb(m, b) * r ** (a + b) * (1 - r) ** (n + m - a - b)
                for a, b in extreme
            )
            for r in np.linspace(0, 1, 2001)
        )

    # tables that tie with the observed one belong to the tail; SciPy's rounding drops some
    without_ties, with_ties = p_value(1e-9), p_value(-1e-9)
    assert without_ties - 2e-3 <= barnard_greater(s, n, t, m) <= with_ties + 2e-3


def test_impossible_counts_are_refused():
    with pytest.raises(ValueError, match="5 successes of 4 trials"):
        barnard_greater(5, 4, 0, 4)
    with pytest.raises(ValueError, match="0 successes of 0 trials"):
        barnard_greater(1, 4, 0, 0)


def test_bonferroni_multiplies_and_stops_at_one():
    assert bonferroni(0.01, 5) == pytest.approx(0.05)
    assert bonferroni(0.4, 5) == 1.0
