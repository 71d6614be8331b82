"""Recordings, LeRobot data sets and models that `t2l gains`, `check` and `retarget` are given."""

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
from t2l.identify.model import ModelFile
from t2l.recordings.importers.lerobot_dataset import Info
from t2l.recordings.metadata import Metadata
from tests.diagnose.made import pendulum
from tests.fuzz.generate import as_bytes, damaged, spoilt
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import METADATA, MODEL, QUIET, table

INFO = {
    "codebase_version": "v3.0", "fps": 50, "total_frames": 40,
    "features": {
        key: {"dtype": "float32", "shape": [1], "names": ["hinge"]}
        for key in ("action", "observation.state")
    },
}  # fmt: skip
NUMBERS = [0.0, 0.3, float("nan"), float("inf"), 1e30, -1e300, 4e6, 7.0]
SOUND = 0.3 * np.sin(0.3 * np.arange(40)[:, None]) + np.zeros((40, 1))


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    pendulum(home)
    # a recording held out, or of the old machine, is another one
    for name, rows in (("sound", table()), ("other", table()[:-1])):
        (home / f"{name}.yaml").write_text(yaml.safe_dump(METADATA))
        (home / f"{name}.csv").write_text("\n".join(map(",".join, rows)))
    (home / "model.yaml").write_text(yaml.safe_dump(MODEL))
    return home


def write_set(folder: Path, info: bytes, action: np.ndarray, state: np.ndarray) -> Path:
    """A data set of two episodes; the path of its table."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    (folder / "meta/info.json").write_bytes(info)
    path = folder / "data/chunk-000/file-000.parquet"
    pd.DataFrame({
        "action": action.tolist(), "observation.state": state.tolist(),
        "episode_index": [0] * 20 + [1] * 20, "frame_index": [*range(20)] * 2,
    }).to_parquet(path)  # fmt: skip
    return path


@settings(max_examples=30, **QUIET)
@given(data=st.data())
def test_data_sets(home, data):
    document = data.draw(st.just(INFO) | spoilt(INFO, Info))
    info = data.draw(as_bytes(document, json_too=True))
    action, state = SOUND.copy(), np.roll(SOUND, 2, axis=0)
    for values in (action, state):
        for at in data.draw(st.lists(st.integers(0, 39), max_size=2)):
            values[at:] = data.draw(st.sampled_from(NUMBERS))
    path = write_set(home / "bad_set", info, action, state)
    if data.draw(st.integers(0, 9)) == 0:
        path.write_bytes(damaged(data.draw, path.read_bytes()))
    # what retarget copies takes lerobot, which takes seconds to import
    retarget = [
        *("retarget", "bad_set", "--robot", "pendulum.xml", "--joints", "hinge", "--out", "out"),
        *("--kp", "20", "--kd", "1", "--to-kp", "0", "--to-kd", "1"),
    ]
    for line in (["gains", "bad_set"], retarget):
        check(lambda line=line: main(line), home, home / "out", ("bad_set", "--to-kp"))
    shutil.rmtree(home / "bad_set")


@settings(max_examples=25, **QUIET)
@given(data=st.data())
def test_gains_of_recordings(home, data):
    rows = table()
    column = data.draw(st.integers(0, 3))
    for at in data.draw(st.lists(st.integers(1, len(rows) - 1), max_size=2)):
        for row in rows[at:]:
            row[column] = repr(data.draw(st.sampled_from(NUMBERS)))
    (home / "bad.csv").write_text("\n".join(map(",".join, rows)))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(data.draw(spoilt(METADATA, Metadata)))))
    check(lambda: main(["gains", "bad"]), home, home / "out", ("bad", "pendulum.xml"))
    for end in ("csv", "yaml"):
        (home / f"bad.{end}").unlink()


@settings(max_examples=25, **QUIET)
@given(data=st.data())
def test_check(home, data):
    (home / "bad_model.yaml").write_bytes(data.draw(as_bytes(data.draw(spoilt(MODEL, ModelFile)))))
    model = data.draw(st.sampled_from(["bad_model.yaml"] * 4 + ["model.yaml"]))
    rows = table()
    for _ in range(data.draw(st.integers(0, 2))):
        at = data.draw(st.integers(1, len(rows) - 1))
        rows[at][data.draw(st.integers(0, 3))] = repr(data.draw(st.sampled_from(NUMBERS)))
    (home / "bad.csv").write_text("\n".join(map(",".join, rows)))
    (home / "bad.yaml").write_text(yaml.safe_dump(METADATA))
    line = ["check", data.draw(st.sampled_from(["bad", "sound"])), "--model", model]
    other = data.draw(st.sampled_from([None, None, "other", "sound", "bad", "nowhere"]))
    line += ["--reference", other] if other else []
    check(lambda: main(line), home, home / "out", ("bad", "sound", "other", "nowhere"))
    for name in ("bad.csv", "bad.yaml", "bad_model.yaml"):
        (home / name).unlink()


def test_the_sound_ones_run(home):
    write_set(home / "set", json.dumps(INFO).encode(), SOUND, np.roll(SOUND, 2, axis=0))
    lines = [
        ["gains", "set"], ["gains", "sound"],
        ["check", "sound", "--model", "model.yaml", "--reference", "other"],
    ]  # fmt: skip
    for line in lines:
        assert check(lambda line=line: main(line), home, home / "out") is None
    shutil.rmtree(home / "set")
