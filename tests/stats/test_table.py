import json
from math import comb
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from t2l.gains import Cell, Grid
from t2l.stats.slopes import share_slopes
from t2l.stats.table import behaviour_cloning_table, printable, to_latex

GRID = Grid(kp=(32, 64, 512), kd=(2, 32, 64), compliant_up_to_kp=128, overdamped_from_kd=32)
STUDY = Path(__file__).parents[3] / "shared" / "data" / "paper_results.json"


def _cells(rates, seeds=2, rollouts=100):
    """One row a cell and seed; the seeds of a cell lie 0.1 about its rate."""
    rows = [
        (cell.kp, cell.kd, s, rate + 0.1 * (s - (seeds - 1) / 2), rollouts)
        for cell, rate in rates.items()
        for s in range(seeds)
    ]
    return pd.DataFrame(rows, columns=["kp", "kd", "seed", "success", "rollouts"])


@pytest.fixture(scope="module")
def table():
    # the four cells of G^CO above the five others; then no difference
    best = {c: 0.8 if GRID.in_compliant_overdamped(c) else 0.3 for c in GRID.cells}
    same = dict.fromkeys(GRID.cells, 0.5)
    return behaviour_cloning_table({"block_stack": _cells(best), "mug": _cells(same)}, GRID)


def test_regions_are_means_over_cells(table):
    row = table.iloc[0]
    assert (row.cells_co, row.cells_rest) == (4, 5)
    assert row.success_co == pytest.approx(0.8)
    assert row.success_rest == pytest.approx(0.3)


def test_p_counts_cells_and_is_corrected_for_two_tasks(table):
    assert table.p[0] == pytest.approx(2 / comb(9, 4))
    assert table.p[1] > 0.4


def test_more_rollouts_and_seeds_of_the_same_cells_change_no_p():
    rates = {c: 0.2 + 0.06 * i for i, c in enumerate(GRID.cells)}
    few = behaviour_cloning_table({"t": _cells(rates)}, GRID)
    many = behaviour_cloning_table({"t": _cells(rates, seeds=4, rollouts=10_000)}, GRID)
    assert few.p[0] == many.p[0]


def test_the_printed_table_has_the_studys_layout(table):
    printed = printable(table)
    assert printed.iloc[0]["Task"] == "Block Stack"
    assert printed.iloc[0]["Success in G^CO"] == "80.0 % (4 cells)"
    assert "±" in printed.iloc[0]["β log2 Kp"]
    latex = to_latex(printed)
    assert r"80.0 \%" in latex
    assert r"$\pm$" in latex
    assert "±" not in latex


def test_too_few_cells_give_no_p():
    few = Grid(kp=(32, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)
    rates = {c: 0.9 if few.in_compliant_overdamped(c) else 0.0 for c in few.cells}
    assert printable(behaviour_cloning_table({"t": _cells(rates)}, few)).p[0] == "cannot be told"


def test_a_grid_of_one_cell_has_nothing_to_compare():
    one = Grid(kp=(32,), kd=(32,), compliant_up_to_kp=128, overdamped_from_kd=32)
    table = behaviour_cloning_table({"t": _cells({Cell(32, 32): 0.3}, seeds=1)}, one)
    row = printable(table).iloc[0]
    assert row["Success in G^CO"] == "30.0 % (1 cell)"
    assert row["Success outside"] == "no cells"
    assert row["p"] == "cannot be told"
    assert row["β log2 Kp"] == "undetermined"


@pytest.mark.skipif(not STUDY.exists(), reason="the study's result grids are not on this machine")
def test_the_studys_own_grids_show_its_trend():
    blocks = json.loads(STUDY.read_text())["bc_success"]
    tasks = {name: block for name, block in blocks.items() if isinstance(block, dict)}
    kp, kd = (tuple(next(iter(tasks.values()))[key]) for key in ("kps", "kds"))
    grid = Grid(kp=kp, kd=kd, compliant_up_to_kp=128, overdamped_from_kd=16)
    for name, block in tasks.items():
        success = np.array(block["success"])
        rates = {Cell(p, d): success[i, j] for i, d in enumerate(kd) for j, p in enumerate(kp)}
        row = behaviour_cloning_table({name: _cells(rates, seeds=1)}, grid).iloc[0]
        assert row.beta_kd > 2 * row.beta_kd_se, name
        # opening the dishwasher is the one task that stiffness does not hurt
        assert row.beta_kp < 0 or name == "Dishwasher Opening", name
        assert row.success_co > row.success_rest, name


def test_slopes_are_those_of_the_regions_table(table):
    best = _cells({c: 0.8 if GRID.in_compliant_overdamped(c) else 0.3 for c in GRID.cells})
    own = best.groupby(["kp", "kd"], as_index=False).success.mean()
    fit = share_slopes(own.kp, own.kd, 200 * own.success, np.full(9, 200))
    assert table.beta_kp[0] == pytest.approx(fit.kp)
