import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from t2l.identify.spectral import mean_squared_error, spectral_error


@given(st.integers(2, 40), st.integers(1, 3), st.integers(0, 2**31))
def test_parseval(ntime, njoint, seed):
    generator = np.random.default_rng(seed)
    simulated = generator.normal(size=(4, ntime, njoint))
    measured = generator.normal(size=(ntime, njoint))
    np.testing.assert_allclose(
        spectral_error(simulated - measured), mean_squared_error(simulated, measured)
    )


def test_a_simulation_that_ran_away_ranks_last():
    difference = np.ones((2, 8, 1))
    difference[1, 3] = np.nan
    np.testing.assert_allclose(spectral_error(difference), [1.0, np.inf])
