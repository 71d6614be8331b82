import os
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest

from t2l.artefacts import read_table, whole, write_table
from t2l.errors import ArtefactError


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


def test_a_folder_takes_the_place_of_the_one_before(tmp_path):
    path = tmp_path / "set"
    for content in ("old", "new"):
        with whole(path) as draft:
            draft.mkdir()
            (draft / content).touch()
    assert os.listdir(path) == ["new"]


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


def test_foreign_tables_are_named(tmp_path):
    path = tmp_path / "table.parquet"
    with pytest.raises(ArtefactError, match="no such file"):
        read_table(path, ("x",))
    write_table(pd.DataFrame({"y": range(100)}), path)
    with pytest.raises(ArtefactError, match=r"table.parquet: lacks column x"):
        read_table(path, ("x",))
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(ArtefactError, match="cannot be read as Parquet"):
        read_table(path, ("y",))
