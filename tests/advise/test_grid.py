import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.advise.grid import default_grid, grid_of_factors, of


def test_the_grid_of_a_wide_range_of_inertias_is_about_that_of_the_study():
    found = default_grid(np.array([[1.4, 2.7, 1.4, 1.0, 0.1, 0.1, 0.07]]))
    assert len(found.cells) == 56
    assert found.kp[0] == pytest.approx(32, rel=0.3)
    assert found.kp[-1] == pytest.approx(2048, rel=0.3)
    assert found.kd[0] == pytest.approx(1, rel=0.4)
    assert found.kd[-1] == pytest.approx(128, rel=0.4)


@given(mass=st.floats(1e-3, 100), factor=st.floats(0.01, 100))
def test_it_scales_with_the_robot(mass, factor):
    one, other = (default_grid(np.array([[mass * f, 2 * mass * f]])) for f in (1.0, factor))
    # rounded to two digits each
    assert np.array(other.kp) == pytest.approx(factor * np.array(one.kp), rel=0.11)
    assert np.array(other.kd) == pytest.approx(factor * np.array(one.kd), rel=0.11)


def test_factors_are_about_the_robots_own_gains():
    found = grid_of_factors()
    assert found.kp == (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
    assert 1.0 in found.kd


def test_cells_go_by_damping_upward_then_by_stiffness():
    found = of([20.0, 5.0], [3.0, 1.0])
    assert [(c.kp, c.kd) for c in found.cells] == [(5, 1), (20, 1), (5, 3), (20, 3)]
