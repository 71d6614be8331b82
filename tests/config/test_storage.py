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
