"""What is left of samples that the others foretell."""

import numpy as np
import pytest

from t2l.detective.left_out import fitted
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.optimiser import Objective, minimise

NOISE, COUNT = 0.1, 400
FOLDS = np.repeat([0, 1, 2, 3], COUNT // 4)


class Lines(Objective):
    """Two numbers, of which the second moves some samples alone."""

    def __init__(self, moved: np.ndarray):
        rng = np.random.default_rng(0)
        self.columns = rng.normal(size=(COUNT, 2)) * np.stack([np.ones(COUNT), moved], axis=1)
        self.measured = self.columns @ (1.0, 2.0) + NOISE * rng.normal(size=COUNT)
        self.joints = np.zeros(COUNT, int)

    def residuals(self, asked):
        return [points @ self.columns.T - self.measured for _, points in asked]


@pytest.mark.parametrize(
    ("moved", "told"),
    [
        (FOLDS >= 0, True),
        # what one recording alone tells, it tells at other times of its own
        (FOLDS == 0, True),
        # but not of a single moment
        (np.arange(COUNT) == 7, False),
    ],
)
def test_what_one_part_alone_tells_is_judged_by_pieces_of_it(moved, told):
    layout = Layout([Term(builtin()["torque_offset"], (0, 1))])
    objective = Lines(moved)
    fit = LeastSquares(layout, np.zeros(2), np.ones(2))
    minimise([fit], objective, 5)
    assert fit.u == pytest.approx([1.0, 2.0], abs=0.5)
    (one,) = fitted([fit], objective, FOLDS[:, None])
    assert one.told[moved].all() == told
    assert one.told[~moved].all()
    assert NOISE / 2 < one.left_out_rmse < 1.2 * NOISE


def test_of_those_far_behind_the_linear_model_tells_what_is_left_out():
    layout = Layout([Term(builtin()["torque_offset"], (0, 1))])
    objective = Lines(np.ones(COUNT, bool))
    near, far = (LeastSquares(layout, np.zeros(2), np.ones(2)) for _ in range(2))
    far.free = np.array([True, False])
    minimise([near, far], objective, 5)
    asked, residuals = [], objective.residuals
    objective.residuals = lambda pairs: asked.extend(fit for fit, _ in pairs) or residuals(pairs)
    exact = fitted([near, far], objective, FOLDS[:, None])
    asked.clear()
    racing = fitted([near, far], objective, FOLDS[:, None], racing=True)
    assert {id(fit) for fit in asked} == {id(near)}
    for one, other in zip(exact, racing, strict=True):
        assert other.left_out_rmse == pytest.approx(one.left_out_rmse, rel=1e-6)


def test_a_part_that_the_others_foretell_better_counts_as_in_the_fit_to_all():
    layout = Layout([Term(builtin()["torque_offset"], (0, 1))])
    objective = Lines(np.ones(COUNT, bool))
    unfinished = LeastSquares(layout, np.zeros(2), np.ones(2))
    minimise([unfinished], objective, 0)
    (one,) = fitted([unfinished], objective, FOLDS[:, None])
    assert one.left_out_rmse >= one.rmse > 10 * NOISE
