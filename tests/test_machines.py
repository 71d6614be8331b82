"""What the benchmark of real machines makes of a folder, and the page that shows it."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from benchmarks import machines
from benchmarks.__main__ import main
from benchmarks.machines import BEGIN, END, by_pieces, chosen, row, shown, with_table

from t2l.detective.data_split import split
from t2l.recordings.log import write_recording
from tests.conftest import ROOT
from tests.diagnose.made import pendulum, swings

HIDDEN = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
PAGE = f"Before.\n\n{BEGIN}\n{END}\n\nAfter.\n"


def machine(folder, effects=None):
    """A pendulum with these effects: three recordings to explain, one that is held out."""
    folder.mkdir(parents=True)
    made = swings(pendulum(folder), effects, duration_s=1.0)
    held = swings(pendulum(folder), effects, duration_s=0.8)[1]
    for part, recordings in (("train", made), ("holdout", [held])):
        (folder / part).mkdir()
        for one in recordings:
            write_recording(one, folder / part / one.name)
    return folder


@pytest.fixture
def results(tmp_path, monkeypatch):
    """The folder of what is kept; workers import the module anew, so one process does it."""
    monkeypatch.setattr(machines, "FOLDER", tmp_path / "kept")
    monkeypatch.setattr(machines.one_core, "each", lambda f, items, processes: map(f, items))
    return tmp_path / "kept"


def test_a_machine_is_explained_and_the_table_stands_in_the_page(tmp_path, results, capsys):
    machine(tmp_path / "data/dry", HIDDEN)
    out = tmp_path / "out"
    out.mkdir()
    (out / "machines.md").write_text(PAGE)
    command = ["machines", "--data", str(tmp_path / "data"), "--leave-outs", "2", "--out", str(out)]
    main(command)
    ((_, found),) = machines.read_table(out).iterrows()
    assert found["lacks"] == "Coulomb friction"
    assert (found["recordings"], found["held out"], found["joints"]) == ("4", "1", "1")
    # what is left is noise of 0.1 mrad
    assert float(found["after [mrad]"]) == pytest.approx(0.1, rel=0.3)
    assert float(found["before [mrad]"]) > 10 * float(found["after [mrad]"])
    assert found["makers [mrad]"] == ""
    assert (found["leads most often"], found["times"]) == ("coulomb_friction", "2 of 2")
    page = (out / "machines.md").read_text()
    assert page.startswith("Before.\n")
    assert page.endswith("After.\n")
    assert "| dry " in page
    # again: from what was kept, with the row of another machine left as it is
    kept = {path: path.stat().st_mtime_ns for path in results.rglob("*.json")}
    machine(tmp_path / "other/clean")
    main(["machines", "--data", str(tmp_path / "other"), *command[-2:]])
    main(command)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    table = machines.read_table(out)
    assert list(table["machine"]) == ["clean", "dry"]
    assert list(table["lacks"]) == ["nothing", "Coulomb friction"]


def test_changed_recordings_are_explained_again(tmp_path, results):
    (one,) = chosen([machine(tmp_path / "dry")], [])
    result = machines.explained(one, None, 60.0)
    path = results / "dry/as given.json"
    path.parent.mkdir(parents=True)
    kept = {"key": machines._key(one), "limit_s": 60.0, **result, "lacks": "kept"}
    path.write_text(json.dumps(kept))
    assert machines.judged((one, None), 60.0)["lacks"] == "kept"
    log = tmp_path / "dry/holdout/kp20.csv"
    log.write_text("".join(log.read_text().splitlines(keepends=True)[:-1]))
    assert machines.judged((one, None), 60.0)["lacks"] == "nothing"


def test_a_search_that_takes_too_long_ends_with_the_best_so_far(tmp_path):
    (one,) = chosen([machine(tmp_path / "dry", HIDDEN)], [])
    result = machines.explained(one, None, 0.05)
    assert result["stopped"]
    assert 1e-3 < result["before"] >= result["after"]
    assert row("dry", [result])["seconds"].endswith(", stopped")


def test_the_makers_model_is_judged_beside(tmp_path, monkeypatch):
    (one,) = chosen([machine(tmp_path / "dry", HIDDEN)], [])
    (tmp_path / "machines.yaml").write_text(json.dumps({"dry": HIDDEN}))
    monkeypatch.setattr(machines, "MAKERS", tmp_path / "machines.yaml")
    result = machines.explained(one, None, 0.05)
    # it is what made the recordings, so that it leaves their noise
    assert result["makers"] == pytest.approx(1e-4, rel=0.3)


def test_stretches_of_time_report_where_recordings_are_few(tmp_path):
    made = swings(pendulum(tmp_path), duration_s=1.0)[:2]
    data = split(made[0].robot, made, threads=1)
    choices = [by_pieces(data, seed) for seed in range(3)]
    for one in choices:
        assert not np.any(one.fitted_mask & one.test_mask)
        for recording in range(2):
            of = one.fitted.samples.recording == recording
            assert np.mean(one.test_mask[of]) == pytest.approx(2 / 8, abs=0.03)
        assert len(one.folds) == np.sum(one.fitted_mask)
        assert set(one.folds[:, 0]) == set(range(12))
    assert len({one.test_mask.tobytes() for one in choices}) == 3


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--data", "absent"], r"--data: found no folder absent"),
        (["--data", "empty"], r"--data: found no machine in empty; allowed: recordings, or train/"),
        (["--data", "some", "wet"], r"no machine wet; there are dry"),
    ],
)
def test_what_is_not_there_is_said(tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    machine(tmp_path / "some/dry")
    with pytest.raises(SystemExit, match=says):
        machines.main(arguments)


def test_a_page_without_the_marks_is_left_alone():
    with pytest.raises(SystemExit, match="found 0 tables"):
        with_table("A page.", pd.DataFrame())


def test_the_page_shows_the_table():
    page = (ROOT / "docs/machines.md").read_text()
    between = re.search(f"{re.escape(BEGIN)}(.*){re.escape(END)}", page, flags=re.S)[1]
    assert between.strip() == shown(machines.read_table())


def test_every_machine_of_the_table_is_described_in_the_page():
    page = (ROOT / "docs/machines.md").read_text()
    for name in machines.read_table()["machine"]:
        assert f"**{name}**" in page
