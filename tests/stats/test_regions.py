import numpy as np
import pandas as pd
import pytest

from t2l.gains import Grid
from t2l.stats.regions import by_cell, printable_regions, region_table

GRID = Grid(
    kp=(32, 128, 512, 2048), kd=(2, 8, 32, 128), compliant_up_to_kp=128, overdamped_from_kd=16
)


def cells(co=0.8, so=0.3, cu=0.3, su=0.1, seeds=3):
    """Success by region; training seeds scatter around it."""
    means, rows = {"CO": co, "SO": so, "CU": cu, "SU": su}, []
    for i, cell in enumerate(GRID.cells):
        for seed in range(seeds):
            success = means[GRID.region(cell)] + 0.005 * (i % 4) + 0.01 * (seed - (seeds - 1) / 2)
            rows.append((cell.kp, cell.kd, seed, success, 100))
    return pd.DataFrame(rows, columns=["kp", "kd", "seed", "success", "rollouts"])


def test_seeds_are_averaged_within_their_cell():
    own = by_cell(cells())
    assert len(own) == 16
    assert set(own.seeds) == {3}
    first = own[(own.kp == 32) & (own.kd == 2)].iloc[0]
    assert first.success == pytest.approx(0.3)
    assert (first.rollouts, first.successes) == (300, pytest.approx(90))


def test_regions_have_means_and_intervals_over_cells():
    row = region_table({"nominal": cells()}, GRID).iloc[0]
    assert (row.cells, row.seeds, row.cells_co) == (16, 3, 4)
    assert row.success_co == pytest.approx(0.8025)
    assert row.lower_co < row.success_co < row.upper_co
    assert row.beta_kp < 0 < row.beta_kd
    assert row.p_co_rest == pytest.approx(1 / 1820)
    assert row.p_co_so == pytest.approx(1 / 70)


def test_more_rollouts_and_seeds_of_the_same_cells_change_no_p():
    few, many = cells(co=0.31), cells(co=0.31, seeds=30)
    p = [region_table({"a": table}, GRID).p_co_rest[0] for table in (few, many)]
    assert p[0] == pytest.approx(p[1])


def test_no_difference_is_not_found():
    row = region_table({"a": cells(0.5, 0.5, 0.5, 0.5)}, GRID).iloc[0]
    assert row.p_co_rest > 0.3


def test_too_few_cells_have_no_p():
    table = cells()
    four = table[table.kp.isin([32, 2048]) & table.kd.isin([2, 128])]
    found = region_table({"a": four}, GRID)
    assert np.isnan(found.p_co_rest[0])
    assert found.least_p_co_rest[0] == 0.25
    printed = printable_regions(found)
    assert printed["p (CO > rest)"][0] == "cannot be told"
    assert printed["CO"][0] == "80.0 %"
