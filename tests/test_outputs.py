import fcntl
import json
import os
import subprocess
import sys

import pytest

from t2l.errors import OutputError
from t2l.outputs import MARK, AlreadyRunningError, claim, output_file, output_folder

ENTRIES = ("result.json", "parts/")


def listing(folder):
    """Every path below a folder with what it holds."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def run(folder, command="t2l compare", content="{}", **options):
    with output_folder(folder, command, ENTRIES, **options) as out:
        (out / "result.json").write_text(content)


def test_a_new_folder_an_empty_one_and_the_commands_own_are_written(tmp_path):
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "empty", tmp_path / "deep/er/new"):
        run(folder)
        (folder / "mine.txt").write_text("mine")
        run(folder, content="again")
        assert listing(folder) == {
            MARK: (folder / MARK).read_bytes(),
            "result.json": b"again",
            "mine.txt": b"mine",
        }


@pytest.mark.parametrize("what", ["a file of somebody", "an entry", "a folder of that name"])
def test_a_folder_of_somebody_elses_is_left_alone(tmp_path, what):
    folder = tmp_path / "theirs"
    folder.mkdir()
    if what == "a folder of that name":
        (folder / "result.json").mkdir()
        (folder / "result.json/thesis.tex").write_text("years of work")
    else:
        (folder / ("result.json" if what == "an entry" else "thesis.tex")).write_text("years")
    before = listing(folder)
    with pytest.raises(OutputError, match="theirs"):
        run(folder)
    assert listing(folder) == before
    if what == "a folder of that name":
        with pytest.raises(OutputError, match=r"result.json: is a folder where a file"):
            run(folder, force=True)
        assert listing(folder) == before


def test_force_takes_what_is_in_the_way_and_says_so_and_leaves_the_rest(tmp_path, capsys):
    folder = tmp_path / "theirs"
    folder.mkdir()
    for name in ("result.json", "thesis.tex"):
        (folder / name).write_text("old")
    run(folder, force=True)
    assert "replacing in" in (said := capsys.readouterr().err)
    assert "result.json" in said
    assert "thesis" not in said
    assert (folder / "thesis.tex").read_text() == "old"
    assert (folder / "result.json").read_text() == "{}"


def test_results_of_another_command_are_not_mixed_with(tmp_path, capsys):
    folder = tmp_path / "out"
    with output_folder(folder, "t2l diagnose", ("diagnosis.json", "models/")) as out:
        (out / "diagnosis.json").write_text("{}")
        (out / "models").mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="holds the results of t2l diagnose; allowed: a new"):
        run(folder)
    run(folder, force=True)
    assert "diagnosis.json, models" in capsys.readouterr().err
    assert sorted(listing(folder)) == [MARK, "notes.txt", "result.json"]


@pytest.mark.parametrize("link", [None, os.link, os.symlink], ids=["itself", "hard", "symbolic"])
def test_no_output_is_an_input(tmp_path, link):
    folder = tmp_path / "out"
    run(folder)
    given = folder / "result.json"
    if link:
        given = tmp_path / "given.json"
        link(folder / "result.json", given)
    with pytest.raises(OutputError, match=r"result.json: is read by this command"):
        run(folder, inputs=[given], force=True)
    with pytest.raises(OutputError, match=r"out: is read by this command"):
        run(folder, inputs=[folder], force=True)


def test_a_link_that_leads_out_of_the_folder_is_not_followed(tmp_path):
    folder = tmp_path / "out"
    run(folder)
    (tmp_path / "elsewhere").mkdir()
    (folder / "parts").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="parts: is a link"):
        run(folder, force=True)


def test_a_forged_mark_removes_nothing_outside(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (tmp_path / "treasure").write_text("gold")
    entries = ["../treasure", str(tmp_path / "treasure")]
    (folder / MARK).write_text(json.dumps({"command": "t2l explain", "entries": entries}))
    (folder / "x").touch()
    run(folder, force=True)
    assert (tmp_path / "treasure").read_text() == "gold"


def test_nothing_is_left_of_a_run_that_makes_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError), output_folder(tmp_path / "a/b", "t2l compare", ENTRIES):
        1 / 0  # noqa: B018
    assert not listing(tmp_path)


def test_what_a_killed_run_leaves_is_the_commands_own(tmp_path):
    script = (
        "import sys, time; from t2l.outputs import output_folder\n"
        "with output_folder(sys.argv[1], 't2l compare', ['result.json']) as out:\n"
        "    (out / 'half').touch(); print('writing', flush=True); time.sleep(60)\n"
    )
    folder = tmp_path / "out"
    process = subprocess.Popen([sys.executable, "-c", script, folder], stdout=subprocess.PIPE)
    process.stdout.readline()
    with pytest.raises(AlreadyRunningError, match="another run is at work here"):
        run(folder)
    process.kill()
    process.wait()
    run(folder)


def test_a_mark_that_vanishes_while_it_is_opened_is_made_anew(tmp_path, monkeypatch):
    """A run that made nothing removes its mark: who opened that one before holds no lock."""
    flock = fcntl.flock

    def vanishing(descriptor, operation):
        flock(descriptor, operation)
        monkeypatch.setattr(fcntl, "flock", flock)
        (tmp_path / "out" / MARK).unlink()

    monkeypatch.setattr(fcntl, "flock", vanishing)
    run(tmp_path / "out")
    assert (tmp_path / "out" / MARK).exists()


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("file/below", "Not a directory"),
        ("file", "is a file; give a folder"),
        ("x" * 300, "File name too long"),
        ("/proc/nowhere", "No such file"),
    ],
)
def test_a_place_that_cannot_be_written_is_told_before_anything_runs(tmp_path, path, said):
    (tmp_path / "file").write_text("mine")
    before = listing(tmp_path)
    with pytest.raises(OutputError, match=said):
        run(tmp_path / path)
    assert listing(tmp_path) == before


def test_a_study_claims_its_folder_and_no_other(tmp_path):
    os.close(claim(tmp_path / "study", "snakemake"))
    (tmp_path / "study/cell").touch()
    os.close(claim(tmp_path / "study", "snakemake"))
    (tmp_path / "other").mkdir()
    (tmp_path / "other/thesis.tex").touch()
    with pytest.raises(OutputError, match=r"thesis.tex that it did not make; allowed: a new"):
        claim(tmp_path / "other", "snakemake")


def test_a_file_is_written_where_none_is(tmp_path, capsys):
    path = tmp_path / "deep/model.yaml"
    with output_file(path, "t2l adopt") as out:
        out.write_text("one")
    with pytest.raises(OutputError, match=r"is there already; allowed: a new name, or --force"):
        output_file(path, "t2l adopt").__enter__()
    with output_file(path, "t2l adopt", force=True) as out:
        out.write_text("two")
    assert f"replacing {path}" in capsys.readouterr().err
    with pytest.raises(OutputError, match="is read by this command"):
        output_file(path, "t2l adopt", inputs=[path], force=True).__enter__()
    with pytest.raises(OutputError, match="is a folder"):
        output_file(tmp_path / "deep", "t2l adopt", force=True).__enter__()
    assert path.read_text() == "two"


def test_a_mark_that_is_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / MARK)
    said = rf"{MARK}: found a named pipe \(FIFO\); allowed: a regular file"
    with pytest.raises(OutputError, match=said), output_folder(tmp_path, "t2l x", ["a"]):
        pass
    with pytest.raises(OutputError, match=said):
        claim(tmp_path, "t2l x")
    assert os.listdir(tmp_path) == [MARK]
