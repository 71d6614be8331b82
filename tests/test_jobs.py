"""What a job of the workflow does about errors, and that the next run mends what was broken."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

from t2l.artefacts import read_json, write_text
from t2l.errors import ArtefactError, OutputError
from t2l.jobs import job
from t2l.robots import ROBOTS
from tests.conftest import ROOT
from tests.made_extension import write_robot


def _script(log, **config):
    """What Snakemake gives a script."""
    return SimpleNamespace(log=[log], config=config)


def _ended(log, body, **arguments):
    with pytest.raises(SystemExit) as caught, job(_script(log), **arguments):
        body()
    return str(caught.value)


def test_a_broken_file_is_set_aside_and_the_message_says_so(tmp_path):
    path, log = tmp_path / "a.json", tmp_path / "logs" / "job.log"
    path.write_text("{")
    (tmp_path / "a.json.broken").write_text("older")
    message = _ended(log, lambda: read_json(path, "an explanation"))
    assert message.startswith(f"error: {path}: found what is not JSON")
    assert message.endswith(
        "; set aside as a.json.broken2; run again: it and what depends on it are made anew"
    )
    assert message in f"error: {log.read_text().partition('error: ')[2].strip()}"
    assert not path.exists()
    assert (tmp_path / "a.json.broken").read_text() == "older"
    assert (tmp_path / "a.json.broken2").read_text() == "{"


def test_a_broken_data_set_is_set_aside_as_a_whole(tmp_path):
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "part").touch()

    def fail():
        raise ArtefactError(tmp_path / "set", "meta: a list", "an object")

    assert "set aside as set.broken" in _ended(tmp_path / "log", fail)
    assert (tmp_path / "set.broken" / "part").exists()


def test_what_says_that_it_is_complete_is_set_aside_with_it(tmp_path):
    journal, marker = tmp_path / "trials.journal", tmp_path / "worker_0.txt"
    journal.write_text("?")
    marker.write_text("name")
    missing = tmp_path / "worker_1.txt"

    def fail():
        raise ArtefactError(journal, "no journal", "one")

    _ended(tmp_path / "log", fail, markers=[marker, missing])
    assert {p.name for p in tmp_path.iterdir()} == {
        "log", "trials.journal.broken", "worker_0.txt.broken"
    }  # fmt: skip


def test_nothing_is_set_aside_for_a_file_that_is_missing(tmp_path):
    message = _ended(tmp_path / "log", lambda: read_json(tmp_path / "a.json", "an explanation"))
    assert "a.json: no such file" in message
    assert "set aside" not in message


def test_other_errors_set_nothing_aside(tmp_path):
    def fail():
        raise OutputError("results are full")

    assert _ended(tmp_path / "log", fail) == "error: results are full"
    with pytest.raises(ZeroDivisionError), job(_script(tmp_path / "log")):
        _ = 1 / 0
    assert "ZeroDivisionError" in (tmp_path / "log").read_text()


def test_a_job_knows_what_extensions_define(tmp_path):
    path = write_robot(tmp_path / "mine.py", "pendulum_of_a_job")
    with job(_script(tmp_path / "log", extensions=[str(path)])):
        assert "pendulum_of_a_job" in ROBOTS.names()
    path = tmp_path / "gone.py"
    with pytest.raises(SystemExit) as caught, job(_script(tmp_path / "log", extensions=[path])):
        pytest.fail("it ran")
    assert str(caught.value) == f"error: extension file {path}: no such file"


def test_every_script_is_a_job():
    for path in sorted((ROOT / "workflow/scripts").glob("*.py")):
        assert "\nwith job(snakemake" in path.read_text(), path
        assert "job(snakemake." not in path.read_text(), path


FULL = "/dev/full"  # whose every write fails as on a full disk


def test_a_full_disk_is_a_message(tmp_path, capsys):
    def fill():
        with open(FULL, "w", buffering=1) as file:
            file.write("x\n")

    assert "No space left on device (the file system at" in _ended(tmp_path / "log", fill)
    with job(_script(FULL)):
        pass
    told = capsys.readouterr().err
    assert told.count("warning: /dev/full: cannot be written: No space left on device") == 1
    assert "Traceback" not in told


def test_a_log_that_cannot_be_opened_is_a_message(tmp_path):
    (tmp_path / "log").mkdir()
    assert f"error: {tmp_path / 'log'}: cannot be written: Is a directory" in _ended(
        tmp_path / "log", lambda: None
    )


SNAKEFILE = """
rule all:
    input: "out.txt"

rule make:
    output: directory("set"), "a.json"
    log: "make.log"
    script: "make.py"

rule take:
    input: "set", "a.json"
    output: "out.txt"
    log: "take.log"
    script: "take.py"
"""
MAKE = """
from t2l.artefacts import whole, write_text
from t2l.jobs import job
with job(snakemake):
    with whole(snakemake.output[0]) as draft:
        draft.mkdir()
        (draft / "part").write_text("part")
    write_text('{"steps": 3}', snakemake.output[1])
"""
TAKE = """
from t2l.artefacts import read_json, write_text
from t2l.jobs import job
with job(snakemake):
    content = read_json(snakemake.input[1], "an explanation", ("steps",))
    write_text(str(content["steps"]), snakemake.output[0])
"""


def _snakemake(folder):
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "--rerun-triggers", "mtime"]
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_running_again_mends_a_broken_file(tmp_path):
    for name, text in {"Snakefile": SNAKEFILE, "make.py": MAKE, "take.py": TAKE}.items():
        write_text(text, tmp_path / name)
    (tmp_path / "set").mkdir()
    (tmp_path / "a.json").write_text('{"ste')
    failed = _snakemake(tmp_path)
    assert failed.returncode != 0
    assert "a.json: found what is not JSON" in failed.stderr
    assert "set aside as a.json.broken; run again" in failed.stderr
    again = _snakemake(tmp_path)
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "out.txt").read_text() == "3"
    assert (tmp_path / "a.json.broken").read_text() == '{"ste'
    assert (tmp_path / "set" / "part").exists()
