import pytest

from t2l import registry
from t2l.config import read_study
from t2l.errors import ConfigurationError
from tests.conftest import ROOT, configuration


@pytest.fixture
def config(monkeypatch):
    """All of the default study; its paths are relative to the project's folder."""
    monkeypatch.chdir(ROOT)
    return configuration("config")


@pytest.fixture
def refused(config):
    """A function of a changed configuration: what is said of it."""

    def said(changed):
        with pytest.raises(ConfigurationError) as error:
            read_study(changed, ROOT / "config")
        return str(error.value)

    return said


@pytest.fixture(autouse=True)
def trusted(monkeypatch):
    """What a configuration names may run, as who runs it has said."""
    monkeypatch.setenv(registry.TRUST, "1")


@pytest.fixture
def no_extensions(monkeypatch):
    """As in a process that has just started, and nothing is left behind."""
    monkeypatch.setattr(registry, "_extensions", {})
