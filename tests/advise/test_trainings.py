import numpy as np

from t2l.advise.grid import of
from t2l.advise.trainings import middle, to_train

GRID = of([1.0, 4.0, 16.0], [0.1, 1.0, 10.0])
LEFT = np.ones(9, bool)


def test_the_best_by_each_of_three_orders_is_named():
    off = np.full(9, 2.0)
    off[[0, 4, 8]] = 0.1
    # softest and most damped comes with index 6, the middle of the diagonal with 4
    assert to_train(7, off, LEFT, GRID.cells) == [7, 6, 4]
    assert to_train(6, off, LEFT, GRID.cells) == [6, 4]


def test_what_is_ruled_out_is_not_named():
    off, left = np.zeros(9), LEFT.copy()
    left[6] = False
    assert 6 not in to_train(0, off, left, GRID.cells)


def test_of_what_is_near_to_critical_the_middle_stiffness_is_named():
    off, kp = np.array([0.1, 0.0, 0.3, 1.0, 0.0]), np.array([100.0, 10.0, 1.0, 20.0, 5.0])
    assert middle(off, np.array([True] * 4 + [False]), kp) == 1
