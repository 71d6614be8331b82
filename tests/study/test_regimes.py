import numpy as np
import pandas as pd

from t2l.gains import Grid
from t2l.study.regimes import TRANSFER_COLUMNS, regimes

GRID = Grid(kp=(16, 512), kd=(2, 24), compliant_up_to_kp=128, overdamped_from_kd=8)


def test_the_regimes_show_what_learning_reaches_and_not_what_a_guard_stops():
    cells = [(c.kp, c.kd) for c in GRID.cells]
    cloning = pd.DataFrame([(*c, 0.5) for c in cells], columns=["kp", "kd", "success"])
    transfer = pd.DataFrame(
        [(*c, 1.0, 0.3, 0.01) for c in cells],
        columns=["kp", "kd", "success_sim_100", "success_sim", "trajectory_error"],
    )
    figure = regimes(cloning, GRID, transfer[[*TRANSFER_COLUMNS]], GRID)
    learned = figure.axes[1]
    np.testing.assert_allclose(learned.images[0].get_array(), 1.0)
    # the region is of transfer
    assert [len(axes.patches) for axes in figure.axes[:3]] == [2, 0, 2]


def test_seeds_of_a_cell_are_averaged_in_the_regimes():
    cloning = pd.DataFrame(
        [(c.kp, c.kd, s) for c in GRID.cells for s in (0.2, 0.6)], columns=["kp", "kd", "success"]
    )
    transfer = pd.DataFrame(
        [(c.kp, c.kd, 1.0, e) for c in GRID.cells for e in (0.01, 0.03)],
        columns=["kp", "kd", "success_sim_100", "trajectory_error"],
    )
    figure = regimes(cloning, GRID, transfer, GRID)
    images = [axes.images[0].get_array() for axes in figure.axes[:3]]
    for image, value in zip(images, (0.4, 1.0, 0.02), strict=True):
        np.testing.assert_allclose(image, np.full((2, 2), value))
