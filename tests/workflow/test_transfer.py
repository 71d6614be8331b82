"""The second chain, on the smoke configuration's results."""

import copy

import pandas as pd
import pytest

CELLS = [(16, 24), (512, 24)]


def test_tables_hold_a_row_a_rollout_and_a_cell(smoke):
    folder = smoke.results / "sim_to_real" / "joint_reach"
    rollouts = pd.read_parquet(folder / "rollouts.parquet")
    cells = pd.read_parquet(folder / "cells.parquet")
    assert len(rollouts) == len(CELLS) * smoke.config["deployment"]["rollouts"]
    assert set(zip(cells.kp, cells.kd, strict=True)) == set(CELLS)
    assert (rollouts.trajectory_error.dropna() > 0).all()
    # whoever was stopped did not succeed
    assert not (rollouts.success & (rollouts.stopped != "")).any()


@pytest.mark.parametrize("name", ["transfer", "jitter", "solution_existence"])
def test_a_table_is_there_in_every_format(smoke, name):
    paths = [smoke.results / "tables" / f"{name}.{suffix}" for suffix in ("csv", "md", "tex")]
    assert all(path.read_text().strip() for path in paths)


def test_side_by_side_studies_go_on_and_all_policies_are_trained(copied):
    folder = copied.results / "sim_to_real" / "joint_reach"
    trials = [folder / f"kp{kp}_kd{kd}" / "trials.parquet" for kp, kd in CELLS]
    before = [pd.read_parquet(path) for path in trials]
    config = copy.deepcopy(copied.config) | {"training_jobs": "variant"}
    config["tuning"]["trials"] += 2
    policies = [path.with_name("seed1") / "policy.safetensors" for path in trials]
    stamps = [path.stat().st_mtime_ns for path in policies]
    done = copied.run(
        "--", *(str(path.relative_to(copied.folder)) for path in policies), config=config
    )
    assert done.returncode == 0, done.stdout[-4000:]
    assert "tune_joint_reach" in done.stdout
    assert "train_policy_joint_reach" in done.stdout
    for path, earlier in zip(trials, before, strict=True):
        after = pd.read_parquet(path)
        assert len(after) == len(earlier) + 2
        pd.testing.assert_frame_equal(after.iloc[: len(earlier)][earlier.columns], earlier)
    for path, stamp in zip(policies, stamps, strict=True):
        assert path.stat().st_mtime_ns > stamp
        assert len(pd.read_parquet(path.with_name("training.parquet")))


def test_more_trials_continue_a_study_and_one_cell_is_one_path(copied):
    cell = copied.results / "sim_to_real" / "joint_reach" / "kp512_kd24"
    other = cell.with_name("kp16_kd24") / "trials.parquet"
    before, others = pd.read_parquet(cell / "trials.parquet"), other.stat().st_mtime_ns
    config = copy.deepcopy(copied.config)
    config["tuning"]["trials"] += 1
    target = "results/smoke/sim_to_real/joint_reach/kp512_kd24/trials.parquet"
    done = copied.run("--", target, config=config)
    assert done.returncode == 0, done.stdout[-4000:]
    after = pd.read_parquet(cell / "trials.parquet")
    assert len(after) == len(before) + 1
    pd.testing.assert_frame_equal(after.iloc[: len(before)][before.columns], before)
    assert other.stat().st_mtime_ns == others
