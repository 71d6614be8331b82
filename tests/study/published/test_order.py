from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from t2l.stats.rank import spearman
from t2l.stats.text import write_printed
from t2l.study.published.grids import COUNTERPARTS
from t2l.study.published.order import printable_published_grids, published_grids_table
from t2l.tasks import TASKS
from tests.conftest import ROOT
from tests.study.published.downloaded import STUDY, published_grids

KP, KD = (grid.ravel() for grid in np.meshgrid([32.0, 64, 128, 256, 512, 1024], [1.0, 4, 16, 64]))
THEIRS = pd.DataFrame({"kp": KP, "kd": KD, "success": KD / KP, "loss": 1 / KP + KD})


def _ours(success, loss):
    """Three seeds a cell, of which no single one is in the order of their mean."""
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(2, len(KP)))
    seeds = [
        pd.DataFrame(
            {
                "kp": KP, "kd": KD, "success": success + off, "validation_loss": loss + off,
                "validation_mse_rad2": -loss,
            }
        )
        for off in (*noise, -noise.sum(axis=0))
    ]  # fmt: skip
    # in another order than theirs
    return pd.concat(seeds, ignore_index=True).sample(frac=1, random_state=0)


def _table(ours, kind="dishwasher", theirs=THEIRS):
    return published_grids_table({"door": ours}, {"door": kind}, {COUNTERPARTS[kind]: theirs})


@pytest.mark.parametrize(("sign", "word"), [(1, "+1.00"), (-1, "-1.00")])
def test_the_same_order_and_the_reverse_are_told_apart(sign, word):
    """The means over seeds are in their order, or in its reverse."""
    table = _table(_ours(sign * THEIRS.success.rank(), THEIRS.loss.rank()))
    rows = table.set_index("quantity")
    assert rows.rho["success"] == pytest.approx(sign)
    assert rows.rho["validation_loss"] == pytest.approx(1)
    assert rows.rho["validation_mse_rad2"] == pytest.approx(-1)
    assert set(table.cells) == {24}
    assert set(table.seeds) == {3}
    printed = printable_published_grids(table)
    assert printed["Task"].tolist() == ["Door"] * 3
    assert printed["Task of the study"][0] == "Dishwasher Opening"
    assert printed.iloc[0, 3].startswith(f"{word} ({word} to {word}")


def test_orders_that_have_nothing_to_do_with_each_other_show_it():
    shuffled = np.random.default_rng(3).permutation(len(KP))
    rho = _table(_ours(shuffled, shuffled)).set_index("quantity").loc["success"]
    assert rho.low < 0 < rho.high


def test_only_cells_that_both_have_count():
    """Of the others, which are in the reverse order, nothing is seen."""
    apart = KP > 128
    success = np.where(apart, -THEIRS.success.rank() - 100, THEIRS.success.rank())
    rows = _table(_ours(success, THEIRS.loss), theirs=THEIRS[~apart]).set_index("quantity")
    assert (rows.rho["success"], rows.cells["success"]) == (pytest.approx(1), 12)
    few = _table(_ours(success, THEIRS.loss), theirs=THEIRS[:6])
    assert np.isnan(few.low).all()
    assert np.isfinite(few.rho).all()
    assert "too few cells" in printable_published_grids(few).iloc[0, 3]


def test_grids_without_a_common_cell_determine_nothing(tmp_path):
    elsewhere = THEIRS.assign(kp=THEIRS.kp + 1)
    table = _table(_ours(THEIRS.success, THEIRS.loss), theirs=elsewhere)
    assert (table.cells.max(), table.seeds.max()) == (0, 0)
    printed = printable_published_grids(table)
    assert set(printed.iloc[:, 3]) == {"undetermined"}
    paths = [tmp_path / f"table.{suffix}" for suffix in ("csv", "md", "tex")]
    write_printed(table, printed, paths)
    assert all(path.stat().st_size > 100 for path in paths)


def test_a_task_without_a_counterpart_has_no_row():
    ours = _ours(THEIRS.success, THEIRS.loss)
    grids = {"Dishwasher Opening": THEIRS}
    # another name for the same task, another task, and one that this file has not
    kinds = {"my_door": "dishwasher", "blocks": "block_stack", "mug": "mug_hanging"}
    table = published_grids_table(dict.fromkeys(kinds, ours), kinds, grids)
    assert set(table.task) == {"my_door"}


def test_a_table_without_rows_can_be_written(tmp_path):
    """The file may have another task of the study than ours is."""
    table = published_grids_table({"mug": _ours(0, 0)}, {"mug": "mug_hanging"}, {"Other": THEIRS})
    assert table.empty
    paths = [tmp_path / f"table.{suffix}" for suffix in ("csv", "md", "tex")]
    write_printed(table, printable_published_grids(table), paths)
    assert all(path.is_file() for path in paths)


def test_counterparts_are_tasks():
    assert set(COUNTERPARTS) <= set(TASKS.names())


@pytest.mark.skipif(not STUDY.is_file(), reason=f"the study's published grids are not at {STUDY}")
def test_our_dishwasher_beside_the_studys_tasks_beside_each_other(tmp_path):
    """What docs/results_errors.md says of both."""
    grids = published_grids(tmp_path)
    assert set(COUNTERPARTS.values()) == set(grids)
    ours = pd.read_csv(ROOT / "docs/data/dishwasher.csv")
    table = published_grids_table({"dishwasher": ours}, {"dishwasher": "dishwasher"}, grids)
    assert table.rho.round(2).tolist() == [0.31, 0.84, 0.91]
    assert table.cells.tolist() == [56] * 3
    success = [grid.success.to_numpy() for grid in grids.values()]
    among = [float(spearman(*pair)) for pair in combinations(success, 2)]
    assert np.round([min(among), max(among)], 2).tolist() == [0.6, 0.77]
