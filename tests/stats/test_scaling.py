"""How success grows with the number of demonstrations."""

import numpy as np
import pandas as pd
import pytest

from t2l.figures.scaling import scaling
from t2l.gains import Grid
from t2l.stats.scaling import by_size, printable_scaling, scaling_table, slopes

GRID = Grid((32, 512), (2, 64), compliant_up_to_kp=32, overdamped_from_kd=64)
SLOPES = {(32, 2): 0.05, (32, 64): 0.2, (512, 2): 0.0, (512, 64): 0.1}


@pytest.fixture
def cells():
    rows = [
        (kp, kd, seed, 0.1 + slope * np.log2(n / 25) + 0.01 * seed, n)
        for (kp, kd), slope in SLOPES.items()
        for n in (25, 50, 200)
        for seed in (-1, 1)
    ]
    return pd.DataFrame(rows, columns=["kp", "kd", "seed", "success", "demonstrations"])


def test_the_slope_is_of_a_doubling_and_policies_of_a_cell_are_averaged(cells):
    table = by_size(cells)
    assert list(table.columns) == [25, 50, 200]
    np.testing.assert_allclose(slopes(table), [SLOPES[cell] for cell in table.index], atol=1e-12)


def test_a_cell_that_lacks_a_number_is_left_out(cells):
    short = cells[~((cells.kp == 512) & (cells.kd == 2) & (cells.demonstrations == 50))]
    table = scaling_table(short, GRID)
    assert set(table.region) == {"CO", "SO", "CU"}
    assert (table.groupby("region").size() == 3).all()


def test_a_row_a_region_is_printed(cells):
    printed = printable_scaling(scaling_table(cells, GRID)).set_index("Region")
    assert printed.loc["CO (1 cell)", "Per doubling"].startswith("+20.0 points")
    assert printed.loc["CO (1 cell)", "200 demonstrations"] == "70.0 %"


def test_a_panel_a_task_and_a_line_a_region_is_drawn(cells):
    table = scaling_table(cells, GRID)
    figure = scaling({"block_stack": table, "dishwasher": table})
    assert [len(panel.lines) for panel in figure.axes] == [4, 4]
    drawn = figure.axes[0].lines[0]
    np.testing.assert_allclose(drawn.get_ydata(), [0.1, 0.3, 0.7], atol=1e-12)
