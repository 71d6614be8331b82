import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.artefacts import (
    read_json,
    read_npz,
    read_table,
    read_text,
    read_yaml,
    set_aside,
    whole,
    write_table,
    write_text,
)
from t2l.diagnose.files import TRACES
from t2l.diagnose.traces import read_traces
from t2l.errors import ArtefactError, OutputError
from t2l.gains import Cell
from t2l.identify.actuators import Identified
from t2l.identify.artefacts import read_parameters, summary, write_parameters
from t2l.plotting import style
from t2l.policies import checkpoint
from t2l.policies.gaussian_mlp import GaussianMLP
from t2l.rl.problem import Choice
from t2l.rl.results import read_chosen, write_chosen
from tests.policies.made import chunk_policy, gaussian_mlp
from tests.report.findings import compared
from tests.rl.test_environments import PARAMETERS


def test_a_failure_half_way_leaves_what_was_there(tmp_path):
    path = tmp_path / "table.parquet"
    write_table(pd.DataFrame({"x": [1]}), path)

    def fail():
        with whole(path) as draft:
            draft.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert read_table(path, ("x",)).x.tolist() == [1]
    assert os.listdir(tmp_path) == ["table.parquet"]


@pytest.mark.parametrize("write", [Path.touch, Path.mkdir], ids=["file", "folder"])
def test_a_folder_that_is_there_stays(tmp_path, write):
    path = tmp_path / "results.yaml"
    path.mkdir()
    (path / "mine").touch()
    refused = pytest.raises(OutputError, match="cannot be written: a folder is there")
    with refused, whole(path) as draft:
        write(draft)
    assert os.listdir(path) == ["mine"]
    assert os.listdir(tmp_path) == ["results.yaml"]


def test_a_folder_does_not_take_the_place_of_a_file(tmp_path):
    (tmp_path / "set").write_text("mine")
    with pytest.raises(OutputError, match="a file is there"), whole(tmp_path / "set") as draft:
        draft.mkdir()
    assert (tmp_path / "set").read_text() == "mine"


def test_only_drafts_of_the_same_file_are_removed(tmp_path):
    kept = [
        ".a.draft-mine.txt",
        ".a.draft-0123456.txt",
        ".a.draft-01234567.txt.bak",
        ".a.draft-01234567.yaml",
        ".ab.draft-01234567.txt",
    ]
    for name in (*kept, ".a.draft-01234567.txt"):
        (tmp_path / name).touch()
    write_text("", tmp_path / "a.txt")
    assert set(os.listdir(tmp_path)) == {*kept, "a.txt"}


@pytest.mark.parametrize(
    "name", ["x" * 255, "é" * 127, "x" * 251 + ".txt", "x." + "y" * 253, "[a]*?.txt"]
)
def test_every_name_of_a_file_can_be_written(tmp_path, name):
    write_text("first", tmp_path / name)
    with whole(tmp_path / name) as draft:
        draft.write_text("first again")
    draft.write_text("what a killed process left")
    write_text("second", tmp_path / name)
    assert os.listdir(tmp_path) == [name]
    assert (tmp_path / name).read_text() == "second"


def test_a_killed_process_leaves_no_artefact(tmp_path):
    path = tmp_path / "table.parquet"
    script = (
        "import sys, time; from t2l.artefacts import whole\n"
        "with whole(sys.argv[1]) as draft:\n"
        "    draft.write_text('half'); print('writing', flush=True); time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", script, path], stdout=subprocess.PIPE)
    process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.1)
    assert not path.exists()
    write_table(pd.DataFrame({"x": [1]}), path)
    assert os.listdir(tmp_path) == ["table.parquet"]


def test_what_is_set_aside_takes_no_ones_place(tmp_path):
    for content in ("first", "second", "third"):
        (tmp_path / "a.yaml").write_text(content)
        set_aside(tmp_path / "a.yaml")
    found = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert found == {
        "a.yaml.broken": "first", "a.yaml.broken2": "second", "a.yaml.broken3": "third"
    }  # fmt: skip


def test_foreign_tables_are_named(tmp_path):
    path = tmp_path / "table.parquet"
    with pytest.raises(ArtefactError, match="no such file"):
        read_table(path, ("x",))
    write_table(pd.DataFrame({"y": range(100)}), path)
    with pytest.raises(ArtefactError, match=r"table.parquet: lacks column x"):
        read_table(path, ("x",))
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(ArtefactError, match="cannot be read"):
        read_table(path, ("y",))
    write_text("x\n1\n", tmp_path / "table.csv")
    assert read_table(tmp_path / "table.csv", ("x",)).x.tolist() == [1]
    with pytest.raises(ArtefactError, match=r"table.csv: lacks column y"):
        read_table(tmp_path / "table.csv", ("y",))


READERS = {
    "a.json": lambda path: read_json(path, "an explanation", ("steps",)),
    "a.yaml": lambda path: read_yaml(path, "a choice", ("steps",)),
    "a.npz": lambda path: read_npz(path, ("steps",)),
    "a.parquet": lambda path: read_table(path, ("steps",)),
    "a.csv": lambda path: read_table(path, ("steps",)),
    "a.safetensors": checkpoint.load,
}


@pytest.mark.parametrize("name", READERS)
def test_whatever_lies_at_a_files_place_is_told(tmp_path, name):
    path = tmp_path / name
    refused = pytest.raises(ArtefactError, match=f"{name}: ")

    def make(content):
        path.write_bytes(content)

    np.save(tmp_path / "single.npy", np.zeros(3))
    np.savez(tmp_path / "pickled.npz", steps=np.array([None]))
    for content in (
        b"", b"\x00", b"\xff\xfe\x00", b"[]", b"1", b"{", b"{}", b"null", b"[" * 5000, b"other: 1",
        (tmp_path / "single.npy").read_bytes(), (tmp_path / "pickled.npz").read_bytes(),
        random.Random(0).randbytes(1000),
    ):  # fmt: skip
        make(content)
        with refused as caught:
            READERS[name](path)
        assert caught.value.path == path
    path.unlink()
    with refused:
        READERS[name](path)
    path.mkdir()
    with pytest.raises(ArtefactError, match=f"{name}: a folder"):
        READERS[name](path)
    path.rmdir()
    os.mkfifo(path)
    with pytest.raises(ArtefactError, match=f"{name}: no regular file"):
        READERS[name](path)


def _json(path):
    write_text(json.dumps({"steps": [{"effect": None, "q": 0.1}] * 3}), path)


def _npz(path):
    with whole(path) as draft:
        np.savez(draft, steps=np.arange(50.0), names=np.array(["a", "bc"]))


def _table(path):
    write_table(pd.DataFrame({"steps": np.arange(200.0), "name": ["a", "b"] * 100}), path)


def _csv(path):
    write_text("steps,name\n1,a\n2,b\n", path)


def _network(path):
    checkpoint.save(chunk_policy(), path)


def _chosen(path):
    write_chosen(path, Cell(128, 16), Choice((0.2, 0.1), {"pace": 1.5}), "trial 3")


def _parameters(path):
    found = Identified(PARAMETERS, np.array([1.0]), 0.1, 0.2, np.zeros(1), np.zeros(1), [])
    write_parameters(found, Cell(128, 16), tuple(f"joint{i}" for i in range(7)), path)


WRITTEN = {
    "text.txt": (lambda path: write_text("a name\n", path), lambda path: read_text(path, "text")),
    "a.json": (_json, READERS["a.json"]),
    "a.npz": (_npz, READERS["a.npz"]),
    "a.parquet": (_table, READERS["a.parquet"]),
    "a.csv": (_csv, READERS["a.csv"]),
    "a.safetensors": (_network, checkpoint.load),
    "policy.safetensors": (lambda path: checkpoint.save(gaussian_mlp(), path), checkpoint.load),
    "chosen.yaml": (_chosen, read_chosen),
    "parameters.yaml": (_parameters, read_parameters),
    "summary.yaml": (_parameters, summary),
}


def _damage(content, draw):
    content = bytearray(content)
    if draw(st.booleans()):
        del content[draw(st.integers(0, len(content))) :]
    for _ in range(draw(st.integers(0, 4))):
        if content:
            content[draw(st.integers(0, len(content) - 1))] = draw(st.integers(0, 255))
    return bytes(content)


@pytest.mark.parametrize("name", WRITTEN)
@settings(max_examples=60)
@given(data=st.data())
def test_a_damaged_file_is_told_or_still_makes_sense(tmp_path_factory, name, data):
    write, read = WRITTEN[name]
    path = tmp_path_factory.getbasetemp() / f"damaged_{name}"
    write(path)
    read(path)
    path.write_bytes(_damage(path.read_bytes(), data.draw))
    with contextlib.suppress(ArtefactError):
        read(path)


@pytest.fixture(scope="module")
def comparison(tmp_path_factory):
    return compared(tmp_path_factory.mktemp("comparison"))


@settings(max_examples=50)
@given(data=st.data())
def test_damaged_traces_are_told_or_still_make_sense(comparison, tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp() / "damaged_traces"
    folder.mkdir(exist_ok=True)
    (folder / TRACES).write_bytes(_damage((comparison / TRACES).read_bytes(), data.draw))
    with contextlib.suppress(ArtefactError):
        read_traces(folder)


@pytest.fixture
def full(tmp_path):
    """A file system of 64 kB."""
    folder = tmp_path / "full"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder]
    if subprocess.run(command, capture_output=True).returncode:
        pytest.skip("needs the right to mount a file system")
    yield folder
    subprocess.run(["umount", folder], check=True)


NOISE = np.random.default_rng(0).normal(size=(300, 300))


def _large_npz(path):
    with whole(path) as draft:
        np.savez(draft, noise=NOISE)


def _picture(path):
    with style.styled():
        figure, axes = plt.subplots()
        axes.imshow(NOISE, interpolation="none")
        style.write(figure, [path])


LARGE = {
    "a.txt": lambda path: write_text("x" * 10**6, path),
    "a.parquet": lambda path: write_table(pd.DataFrame({"x": NOISE.ravel()}), path),
    "a.npz": _large_npz,
    "a.safetensors": lambda path: checkpoint.save(
        GaussianMLP(NOISE[0], NOISE[0], (NOISE,), (NOISE[0],), NOISE[0]), path
    ),
    "a.png": _picture,
    "a.pdf": _picture,
    "a.svg": _picture,
}


@pytest.mark.parametrize("name", LARGE)
def test_a_full_disk_is_told(full, name):
    path = full / name
    (full / "small.txt").write_text("small")
    with pytest.raises(OutputError) as caught:
        LARGE[name](path)
    assert f"{path}: cannot be written: No space left on device" in str(caught.value)
    assert f"(the file system at {full})" in str(caught.value)
    assert os.listdir(full) == ["small.txt"]


def test_a_read_only_disk_is_told(full):
    subprocess.run(["mount", "-o", "remount,ro", full], check=True)
    with pytest.raises(OutputError, match=rf"Read-only file system \(the file system at {full}"):
        write_text("", full / "a.txt")
