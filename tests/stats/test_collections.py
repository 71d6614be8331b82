import numpy as np
import pandas as pd
import pytest

from t2l.gains import Grid
from t2l.stats.collections import (
    best_elsewhere,
    by_collection,
    collections_table,
    contrast,
    crossed,
    over_collections,
    printable_collections,
)

GRID = Grid(
    kp=(32, 128, 512, 2048), kd=(2, 8, 32, 128), compliant_up_to_kp=128, overdamped_from_kd=16
)


def policies(co_so=0.1, shift=0.1, cell=0.0, own=0.02, collections=6, seed=0):
    """Success of a policy a cell and collection: effects of region, collection, cell, and both."""
    rng, rows = np.random.default_rng(seed), []
    of_cell = (
        {each: rng.normal(0, cell) for each in GRID.cells} if cell else dict.fromkeys(GRID.cells, 0)
    )
    for number in range(collections):
        luck = rng.normal(0, shift)
        for each in GRID.cells:
            mean = 0.5 + co_so * (GRID.region(each) == "CO") + luck + of_cell[each]
            rows.append((number, each.kp, each.kd, mean + rng.normal(0, own), 100))
    return pd.DataFrame(rows, columns=["collection", "kp", "kd", "success", "rollouts"])


def table(cells):
    return collections_table({"a": cells}, GRID).iloc[0]


def test_luck_that_a_collection_shares_does_not_hide_a_difference():
    row = table(policies())
    assert row.co_so == pytest.approx(0.1, abs=0.02)
    assert 0 < row.co_so_lower < 0.1 < row.co_so_upper
    assert row.verdict == "reproduced"


def test_an_interval_covers_as_often_as_it_says():
    found = [
        over_collections(contrast(by_collection(policies(0.05, own=0.1, seed=seed), GRID), ["SO"]))
        for seed in range(60)
    ]
    assert np.mean([one.lower < 0.05 < one.upper for one in found]) > 0.85


def test_luck_of_a_region_in_a_collection_is_no_more_certain_with_more_cells():
    rng, cells = np.random.default_rng(1), policies(0, own=0.001)
    luck = rng.normal(0, 0.1, 6)
    inside = [GRID.region(each) == "CO" for each in GRID.cells] * 6
    cells["success"] += luck[cells.collection] * np.array(inside)
    row = table(cells)
    # sixteen cells agree, six collections do not
    assert row.verdict == "cannot be told"
    assert row.co_so_upper - row.co_so_lower > 0.1


def test_cells_that_differ_widen_what_is_said_of_other_cells():
    row = table(policies(cell=0.1))
    assert row.co_so_crossed == pytest.approx(row.co_so)
    widths = [row[f"{key}_upper"] - row[f"{key}_lower"] for key in ("co_so", "co_so_crossed")]
    assert widths[1] > 3 * widths[0]


def test_the_mixed_model_has_the_error_of_a_balanced_design():
    cells = by_collection(policies(cell=0.1, seed=3), GRID)
    both = cells[cells.region.isin(["CO", "SO"])]
    means = both.groupby(["region", "kp", "kd"]).success.mean()
    # with little else than cells, the error is that of two means of four cells
    error = np.sqrt(sum(means[word].var(ddof=1) / 4 for word in ("CO", "SO")))
    found = crossed(cells)
    assert (found.upper - found.lower) / (2 * 2.447) == pytest.approx(error, rel=0.1)


def test_the_contrary_is_said_too():
    assert table(policies(-0.1)).verdict == "not reproduced"


def test_four_collections_tell_nothing():
    row = table(policies(0.3, collections=4))
    assert row.verdict == "cannot be told"
    assert np.isnan(row.co_so_lower)
    assert row.co_so == pytest.approx(0.3, abs=0.03)


def test_a_collection_that_lacks_cells_is_left_out():
    cells = policies()
    assert table(cells.iloc[:-1]).collections == 5


def test_very_stiff_columns_can_be_left_out():
    cells = policies(0)
    cells.loc[cells.kp == 2048, "success"] -= 0.4
    row = table(cells)
    assert row.co_so > 0.15
    assert row.co_so_below_1024_lower < 0 < row.co_so_below_1024_upper


def test_slopes_are_of_collections():
    cells = policies(0, shift=0.05, own=0.01)
    cells["success"] += 0.04 * np.log2(cells.kd / 16) - 0.02 * np.log2(cells.kp / 256)
    row = table(cells.assign(success=cells.success.clip(0, 1)))
    assert row.beta_kd_lower > 0 > row.beta_kp_upper


def test_training_seeds_of_a_policy_are_averaged():
    cells = policies()
    twice = pd.concat([cells, cells.assign(success=cells.success + 0.02)])
    first, both = (contrast(by_collection(own, GRID), ["SO"]) for own in (cells, twice))
    assert len(both) == 6
    assert both == pytest.approx(first)


def test_a_fall_is_claimed_by_its_sign_and_more_tests_ask_for_more():
    falls = np.array([-0.2, -0.1, -0.3, -0.15, -0.02])
    assert over_collections(falls, -1).verdict == "reproduced"
    assert over_collections(falls).verdict == "not reproduced"
    assert over_collections(falls, -1, tests=20).verdict == "cannot be told"


def test_what_chose_a_way_of_training_does_not_report_it():
    noise = {str(i): policies(0, shift=0, own=0.1, seed=i) for i in range(6)}
    # the best of pure chance is no better in collections that it was not chosen in
    assert best_elsewhere(noise).success.mean() == pytest.approx(0.5, abs=0.03)
    better = {**noise, "better": policies(0, shift=0, own=0.01).assign(success=0.9)}
    assert (best_elsewhere(better).success == 0.9).all()


def test_nothing_is_said_of_no_collections():
    assert over_collections(np.array([])).verdict == "cannot be told"


def test_a_row_is_told():
    printed = printable_collections(collections_table({"epochs_50": policies()}, GRID)).iloc[0]
    assert printed["Collections drawn anew"] == "Epochs 50"
    assert printed["CO beats SO"] == "reproduced"
    assert " to +" in printed["CO − SO"]
