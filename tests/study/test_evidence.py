from pathlib import Path

import pandas as pd
import pytest

from t2l.artefacts import write_table
from t2l.study.evidence import AbsentError, AmbiguousError, Evidence, found_in, source_of

CELLS = pd.DataFrame({"kp": [1.0], "kd": [2.0], "success": [0.5]})


@pytest.mark.parametrize(
    ("path", "kind", "fields"),
    [
        ("block_stack/chunk_1/cells.parquet", "cloning", {"variant": "chunk_1"}),
        ("sim_to_real/joint_reach/cells.parquet", "policies", {"condition": "joint_reach"}),
        ("sim_to_real/joint_reach/rollouts.parquet", "transfer", {"condition": "joint_reach"}),
        ("sim_to_real/a/kp16_kd2/seed3/training.parquet", "training", {"seed": "3"}),
        ("sim_to_real/a/kp16_kd2/again/12_seed3.parquet", "again", {"configuration": "12"}),
        ("tables/transfer_decision_joint_reach.csv", "decision", {"condition": "joint_reach"}),
        ("block_stack/noise/kp16_kd2/noisy_replays.parquet", "noise", {"cell": "kp16_kd2"}),
        ("sim_to_real/identification.parquet", "identification", {}),
        ("block_stack/fidelity/kp16_kd2.parquet", "fidelity", {"cell": "kp16_kd2"}),
    ],
)
def test_a_path_says_what_a_table_holds(path, kind, fields):
    source = source_of(f"/somewhere/results/mine/{path}")
    assert (source.study, source.kind) == ("mine", kind)
    assert fields.items() <= dict(source.fields).items()


@pytest.mark.parametrize("path", ["results/mine/figures/a.pdf", "elsewhere/a/cells.parquet", "x"])
def test_other_files_are_no_evidence(path):
    assert source_of(path) is None


def test_tables_are_found_and_each_is_of_one_study(tmp_path):
    for study, success in (("mine", 0.1), ("other", 0.9)):
        folder = tmp_path / "results" / study / "block_stack" / "nominal"
        folder.mkdir(parents=True)
        write_table(CELLS.assign(success=success), folder / "cells.parquet")
    (tmp_path / "results/other/block_stack/chunk_1").mkdir()
    write_table(CELLS, tmp_path / "results/other/block_stack/chunk_1/cells.parquet")
    paths = [path for name in ("mine", "other") for path in found_in(tmp_path / "results" / name)]
    evidence = Evidence.read(paths)
    assert evidence.studies == ["mine", "other"]
    assert evidence.names("cloning", "variant") == ["nominal", "chunk_1"]
    columns = ("kp", "kd", "success")
    assert len(evidence.table("cloning", columns, variant="chunk_1")) == 1
    nominal = {"task": "block_stack", "variant": "nominal"}
    with pytest.raises(AmbiguousError, match="mine and other have a table of block_stack nominal"):
        evidence.table("cloning", columns, **nominal)
    for study, success in (("mine", 0.1), ("other", 0.9)):
        table = evidence.only(study).table("cloning", columns, **nominal)
        assert table.success.tolist() == [success]


def test_what_is_absent_is_named():
    source = source_of(Path("results/mine/block_stack/nominal/cells.parquet"))
    evidence = Evidence([(source, CELLS)])
    with pytest.raises(AbsentError, match="no table of joint_reach transfer"):
        evidence.table("transfer", ("kp",), condition="joint_reach")
    with pytest.raises(AbsentError, match="has no rollouts"):
        evidence.table("cloning", ("kp", "rollouts"), task="block_stack")
    with pytest.raises(AbsentError, match="no table"):
        Evidence([(source, CELLS[:0])]).table("cloning", ("kp",))
