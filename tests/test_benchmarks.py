"""Benchmarks are run by hand and seldom: that they begin at all is tested."""

from importlib import import_module
from pkgutil import iter_modules

import benchmarks
import pandas as pd
import pytest
from benchmarks import collections, earlier, from_truth
from benchmarks.hidden_effects.cases import cases
from benchmarks.scene import ROOT

from t2l.artefacts import write_table
from t2l.demos.collect import TABLE_COLUMNS
from t2l.effects.registry import builtin
from t2l.study.kept.evidence import FILES, named_collections
from tests.study.planted import cloning

MODULES = [module.name for module in iter_modules(benchmarks.__path__) if not module.ispkg]


@pytest.mark.parametrize("name", sorted(set(MODULES) - {"__main__"}))
def test_a_benchmark_can_be_imported(name):
    import_module(f"benchmarks.{name}")


def test_a_checkout_says_which_effects_it_knows():
    assert earlier.names(ROOT) == list(builtin())


def test_true_numbers_leave_the_noise_by_simulation_and_along_the_motion(tmp_path, monkeypatch):
    """Physics that shares no code with the library made the recordings."""
    monkeypatch.setattr(from_truth, "FOLDER", tmp_path)
    (case,) = (case for case in cases(None) if case.name == "viscous_friction_1_pendulum")
    left = from_truth.left_from_truth(case)
    assert 0.9 < left["times the noise"] < 1.1
    assert 0.9 < left["along, times"] < 1.1


def test_collections_of_a_run_join_what_is_kept_of_others(tmp_path, monkeypatch):
    cells = cloning(CO=0.7).assign(seed=0, validation_loss=0.01, validation_mse_rad2=1e-3)
    for name in ("dishwasher", "dishwasher/collection1", "dishrack_unloading"):
        folder = tmp_path / "results/collections_tasks" / name / "nominal"
        folder.mkdir(parents=True)
        # of the last a cell is missing: it is not whole
        own = cells if name.startswith("dishwasher") else cells[1:]
        write_table(own, folder / "cells.parquet")
        ways = ["", "slipped", "slipped"]
        write_table(
            pd.DataFrame({"kp": 32.0, "kd": 2.0, "failure": ways}), folder / "rollouts.parquet"
        )
    kept = pd.read_csv(collections.DATA / "collections.csv").query("task == 'block_stack'")
    kept.to_csv(tmp_path / "collections.csv", index=False)
    monkeypatch.setattr(collections, "DATA", tmp_path)
    found = collections.main([str(tmp_path / "results")])
    assert found.to_numpy().tolist() == [["dishwasher", "nominal", 2]]
    table = pd.read_csv(tmp_path / "collections.csv")
    assert len(table) == len(kept) + 2 * len(cells)
    ways = pd.read_csv(tmp_path / "collections_failures.csv", keep_default_na=False)
    ways = ways[ways.task == "dishwasher"].to_numpy().tolist()
    assert ways == [
        ["dishwasher", number, 32, 2, kind, count]
        for number in (0, 1)
        for kind, count in (("", 1), ("slipped", 2))
    ]
    pd.testing.assert_frame_equal(
        table[table.task == "block_stack"].reset_index(drop=True),
        kept.sort_values(collections.COLUMNS[:6], ignore_index=True),
    )
    # and so the claims read them, as results of the study that made them
    paths = [path for path, _ in FILES["collections"](table)]
    assert "collections_tasks/dishwasher/nominal/cells.parquet" in paths
    assert "collections_tasks/dishwasher/collection1/nominal/cells.parquet" in paths
    assert "Dishwasher, 150 epochs" in named_collections(table)
    # of an operator, the attempts too; times are of those that succeed
    folder = tmp_path / "results/end_to_end/block_stack_teleoperated/collection1/operator/kp32_kd2"
    folder.mkdir(parents=True)
    tried = pd.DataFrame(
        [(32.0, 2.0, 0, True, "", 5.0, 2.0), (32.0, 2.0, 1, False, "missed", 12.0, 2.0)],
        columns=[*TABLE_COLUMNS],
    )
    write_table(tried, folder / "replays.parquet")
    row = collections.attempts(tmp_path / "results").iloc[0]
    assert (row.collection, row.attempts, row.successes, row.time_s) == (1, 2, 1, 5.0)
    with pytest.raises(SystemExit, match="has no collections"):
        collections.main([str(tmp_path / "nothing")])
