import numpy as np
import pytest

from t2l.identify.cma_es import CMAES, Part
from t2l.identify.optimiser import Objective, minimise

BOUNDS = np.array([[-5.0, 5.0], [-5.0, 5.0]])


class Bowls(Objective):
    """Two joints, each with its lowest point; runs away where an element is above `edge`."""

    def __init__(self, lowest, edge=np.inf):
        self.lowest, self.edge = np.array(lowest), edge
        self.joints = np.arange(2)
        self.seen = []

    def residuals(self, asked):
        self.seen += [points for _, points in asked]
        return [np.where(points > self.edge, np.nan, points - self.lowest) for _, points in asked]


def search(u, **changes):
    return CMAES(
        np.array(u, float), BOUNDS, **{"sigma": 1.0, "population": 10, "seed": 0} | changes
    )


@pytest.mark.parametrize(
    "parts",
    [None, [Part(np.array([i]), np.arange(2) == i) for i in (0, 1)]],
    ids=["together", "each joint by itself"],
)
def test_the_lowest_point_is_found(parts):
    found = search([3.0, 3.0], parts=parts)
    minimise([found], Bowls([1.0, -2.0]), 40)
    assert found.u == pytest.approx([1.0, -2.0], abs=1e-2)
    assert found.loss == pytest.approx(0.0, abs=1e-4)
    assert found.iterations == 40


def test_points_lie_within_bounds_and_elements_of_no_part_stay():
    bowls = Bowls([20.0, -2.0])
    found = search([4.0, 3.0], parts=[Part(np.array([0]), np.array([True, False]))])
    minimise([found], bowls, 20)
    every = np.concatenate(bowls.seen)
    assert every[:, 0].max() <= 5.0
    assert set(every[:, 1]) == {3.0}
    assert found.u == pytest.approx([5.0, 3.0], abs=1e-2)


def test_a_search_in_other_units_asks_for_the_same_points_in_them():
    plain, scaled = Bowls([0.2, 0.1]), Bowls([0.2, 0.1])
    minimise([search([0.0, 0.0], sigma=0.5)], plain, 3)
    minimise([search([0.0, 0.0], scale=0.5)], scaled, 3)
    np.testing.assert_allclose(np.concatenate(plain.seen), np.concatenate(scaled.seen))


def test_nothing_worse_than_the_start_is_found():
    found = search([1.0, -2.0])
    minimise([found], Bowls([1.0, -2.0]), 3)
    assert found.u.tolist() == [1.0, -2.0]
    assert found.loss == 0.0
    without = search([1.0, -2.0], from_start=False)
    minimise([without], Bowls([1.0, -2.0]), 3)
    assert without.loss > 0.0


def test_a_simulation_that_runs_away_ranks_last():
    found = search([3.0, 3.0], from_start=False)
    minimise([found], Bowls([1.0, -2.0], edge=2.5), 40)
    assert found.u == pytest.approx([1.0, -2.0], abs=0.05)


def test_where_everything_runs_away_it_stays_at_the_start():
    found = search([3.0, 3.0])
    minimise([found], Bowls([1.0, -2.0], edge=-6.0), 3)
    assert found.u.tolist() == [3.0, 3.0]
    assert found.loss == np.inf


def test_searches_share_their_simulations():
    """What all of them ask for in a round is asked for at once."""
    calls = []

    class Counted(Bowls):
        def residuals(self, asked):
            calls.append([len(points) for _, points in asked])
            return super().residuals(asked)

    fits = [search([3.0, 3.0]), search([0.0, 0.0], population=6)]
    minimise(fits, Counted([1.0, -2.0]), 2)
    assert calls == [[1, 1], [10, 6], [10, 6]]
