"""What the shipped configurations come to: `effective/` says it in full."""

import pytest
import yaml

from t2l.config import effective, read_study
from t2l.config.models import Configuration
from t2l.typed import check
from tests.conftest import ROOT

FILES = [ROOT / "config/config.yaml", *sorted((ROOT / "config/studies").glob("*.yaml"))]
HERE = ROOT / "tests/config/effective"

each_file = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


def _read(path):
    return yaml.safe_load(path.read_text())


@each_file
def test_a_file_comes_to_what_it_always_came_to(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    sections = read_study(_read(path), ROOT / "config").sections
    frozen = _read(HERE / path.name)
    assert set(sections) == set(frozen)
    # Snakemake compares parameters by their text
    for name, section in frozen.items():
        assert repr(sections[name]) == repr(section), name


def test_every_file_is_frozen():
    assert {path.name for path in FILES} == {path.name for path in HERE.glob("*.yaml")}


@each_file
def test_a_file_holds_only_what_is_not_the_default(path):
    defaults = effective({"study": "x"})
    for name, section in _read(path).items():
        if isinstance(section, dict) and name in defaults:
            same = [key for key, value in section.items() if defaults[name].get(key) == value]
            assert not same, f"{name}: {same}"
        else:
            assert section != defaults.get(name), name


@each_file
def test_a_study_is_named_after_its_file(path):
    assert _read(path)["study"] == ("default" if path.stem == "config" else path.stem)


def test_defaults_are_within_their_bounds():
    defaults = effective({"study": "x"})
    assert repr(check(Configuration, defaults).model_dump(exclude_none=True)) == repr(defaults)


def test_defaults_are_nobodys_to_change():
    effective({"study": "x"})["grid"]["kp"].append(0)
    assert 0 not in effective({"study": "x"})["grid"]["kp"]
