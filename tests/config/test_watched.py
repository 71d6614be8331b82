import shutil

import pytest

from t2l.config.watched import watched
from tests.conftest import ROOT

ARM = ROOT / "examples/two_joint_arm"


@pytest.fixture
def folder(tmp_path):
    """A recording, a model and effects, of a robot in two files."""
    shutil.copytree(ARM / "train", tmp_path / "train")
    (tmp_path / "two_joint_arm.xml").write_text('<mujoco><include file="body.xml"/></mujoco>')
    (tmp_path / "body.xml").write_text("<mujoco/>")
    (tmp_path / "effects").mkdir()
    for name in ("effects/a.py", "effects/b.py", "own.py"):
        (tmp_path / name).touch()
    (tmp_path / "model.yaml").write_text("robot: fr3\neffect_files: [own.py, nowhere.py]\n")
    return tmp_path


def test_files_of_recordings_robots_model_and_effects_are_watched(folder):
    found = watched(
        {
            "recordings": [str(folder / "train/medium_steps")],
            "holdout": [str(folder / "train")],
            "model": str(folder / "model.yaml"),
            "effects": [str(folder / "effects")],
        }
    )
    names = {path.removeprefix(f"{folder}/") for path in found}
    assert len(found) == len(set(found))
    assert {
        *("train/medium_steps.csv", "train/medium_steps.yaml", "train/stiff_chirp.csv"),
        *("two_joint_arm.xml", "body.xml", "model.yaml", "own.py"),
        *("effects/a.py", "effects/b.py"),
    } <= names
    assert any("fr3" in name for name in names - {"model.yaml"})


@pytest.mark.parametrize("content", ["robot: [1", "- 1", "robot: nowhere.xml", "robot: 3", ""])
def test_what_cannot_be_read_is_left_to_the_job(folder, content):
    path = folder / "train/medium_steps.yaml"
    path.write_text(content)
    assert str(path) in watched({"recordings": [str(folder / "train/medium_steps.csv")]})


def test_no_diagnosis_watches_nothing():
    assert watched({}) == []
