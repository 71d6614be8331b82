import os
import re
import sqlite3

import pytest

from t2l.config import storage


@pytest.mark.parametrize("url", ["journal", "sqlite:///studies.db"])
def test_what_can_be_opened_is_fine(url):
    assert storage.problems(url) == []


@pytest.mark.parametrize(
    "url",
    [
        "jornal",
        "sqlite//x",
        "nosuch://host/x",
        "redis://host",
        "mssql+nosuch://host/x",
        "sqlite:///nowhere/studies.db",
    ],
)
def test_what_cannot_be_opened_is_told_before_any_job(config, refused, url):
    config["tuning"]["storage"] = url
    text = refused(config)
    assert text.startswith("config: tuning.storage: found ")
    assert "allowed: journal, or the URL of a database" in text


def test_passwords_are_not_shown():
    (problem,) = storage.problems("nosuch://me:secret@host/x")
    assert "secret" not in str(problem)


def test_a_database_of_optunas_is_continued(tmp_path):
    import optuna

    url = f"sqlite:///{tmp_path}/studies.db"
    optuna.create_study(storage=url, study_name="x")
    before = (tmp_path / "studies.db").read_bytes()
    assert storage.problems(url) == []
    (tmp_path / "new.db").touch()
    assert storage.problems(f"sqlite:///{tmp_path}/new.db") == []
    assert (tmp_path / "studies.db").read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.db", "studies.db"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("text", "is no database of Optuna's"),
        ("other.db", "is no database of Optuna's"),
        ("broken.db", "cannot be read"),
        ("pipe", r"a named pipe \(FIFO\)"),
        ("", "cannot be read"),
    ],
)
def test_a_file_of_another_kind_is_not_touched(tmp_path, name, said):
    (tmp_path / "text").write_text("root:x:0:0")
    with sqlite3.connect(tmp_path / "other.db") as other:
        other.execute("CREATE TABLE mine (a)")
    other.close()
    (tmp_path / "broken.db").write_bytes(b"SQLite format 3\0" + b"x" * 2000)
    os.mkfifo(tmp_path / "pipe")
    (problem,) = storage.problems(f"sqlite:///{tmp_path}/{name}")
    assert re.search(said, problem.found), problem


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("sqlite:////etc/passwd", "/etc/passwd, a file that is there and is no database"),
        ("sqlite:////dev/null", "a device"),
        ("sqlite://", "a database in memory"),
        ("sqlite:///:memory:", "a database in memory"),
        ("sqlite:///file:/etc/passwd?uri=true", "with options of SQLite"),
    ],
)
def test_places_of_others_are_refused(url, said):
    (problem,) = storage.problems(url)
    assert said in problem.found
