import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from t2l.gains import Cell, Grid
from t2l.stats.barnard import barnard_greater
from t2l.stats.logistic import logistic_regression
from t2l.stats.table import behaviour_cloning_table, printable, to_latex

GRID = Grid(kp=(32, 512), kd=(2, 32), compliant_up_to_kp=128, overdamped_from_kd=32)
STUDY = Path(__file__).parents[3] / "shared" / "data" / "paper_results.json"


def _rollouts(rates, n):
    """Rollouts with given success counts per cell."""
    rows = [(cell.kp, cell.kd, i, i < count) for cell, count in rates.items() for i in range(n)]
    return pd.DataFrame(rows, columns=["kp", "kd", "rollout", "success"])


@pytest.fixture(scope="module")
def table():
    counts = dict(zip(GRID.cells, [5, 2, 9, 4], strict=True))
    other = dict(zip(GRID.cells, [5, 5, 5, 5], strict=True))
    tasks = {"block_stack": _rollouts(counts, 10), "block_turn": _rollouts(other, 10)}
    return behaviour_cloning_table(tasks, GRID)


def test_counts_of_both_regions(table):
    row = table.iloc[0]
    assert (row.rollouts_co, row.rollouts_rest) == (10, 30)
    assert row.success_co == pytest.approx(0.9)
    assert row.success_rest == pytest.approx(11 / 30)


def test_p_is_barnards_corrected_for_two_tasks(table):
    assert table.p[0] == pytest.approx(2 * barnard_greater(9, 10, 11, 30))
    assert table.p[1] == 1.0


def test_the_printed_table_has_the_studys_layout(table):
    printed = printable(table)
    assert printed.iloc[0]["Task"] == "Block Stack"
    assert printed.iloc[0]["Success in G^CO"] == "90.0 %"
    assert "±" in printed.iloc[0]["β log2 Kp"]
    latex = to_latex(printed)
    assert r"90.0 \%" in latex
    assert r"$\pm$" in latex
    assert "±" not in latex


def test_a_grid_of_one_cell_has_nothing_to_compare():
    one = Grid(kp=(32,), kd=(32,), compliant_up_to_kp=128, overdamped_from_kd=32)
    table = behaviour_cloning_table({"t": _rollouts({Cell(32, 32): 3}, 10)}, one)
    row = printable(table).iloc[0]
    assert row["Success in G^CO"] == "30.0 %"
    assert row["Success outside"] == "no cells"
    assert row["p"] == row["β log2 Kp"] == "undetermined"


@pytest.mark.skipif(not STUDY.exists(), reason="the study's result grids are not on this machine")
def test_the_studys_own_grids_show_its_trend():
    blocks = json.loads(STUDY.read_text())["bc_success"]
    tasks = {name: block for name, block in blocks.items() if isinstance(block, dict)}
    kp, kd = (tuple(next(iter(tasks.values()))[key]) for key in ("kps", "kds"))
    grid = Grid(kp=kp, kd=kd, compliant_up_to_kp=128, overdamped_from_kd=16)
    for name, block in tasks.items():
        success = np.array(block["success"])
        counts = {
            Cell(p, d): round(200 * success[i, j])
            for i, d in enumerate(kd)
            for j, p in enumerate(kp)
        }
        rollouts = _rollouts(counts, 200)
        fit = logistic_regression(rollouts.kp, rollouts.kd, rollouts.success)
        assert fit.kd > 2 * fit.kd_error, name
        # opening the dishwasher is the one task that stiffness does not hurt
        assert fit.kp < 0 or name == "Dishwasher Opening", name
        inside = [
            grid.in_compliant_overdamped(Cell(*c))
            for c in zip(rollouts.kp, rollouts.kd, strict=True)
        ]
        assert rollouts.success[inside].mean() > rollouts.success[~np.array(inside)].mean(), name
