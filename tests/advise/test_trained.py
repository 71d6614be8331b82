import numpy as np
import pytest

from t2l.advise.advice import advised, settled
from t2l.advise.shown import of_dataset
from t2l.advise.trained import FILE, Recipe, begun, trained, trainings_of
from t2l.config.tasks import read_task_file
from t2l.demos.expert import demonstrate
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.tasks import make_task
from tests.advise import test_advice as of_arm
from tests.advise.made import dataset
from tests.conftest import ROOT

SMALL = {
    "policy": "chunk_regression", "validation_fraction": 0.3, "epochs": 1, "hidden": [8],
    "history": 1, "chunk": 5,
}  # fmt: skip


@pytest.fixture(scope="module")
def recipe():
    task = make_task(read_task_file(ROOT / "config/tasks/block_stack.yaml"))
    shown = demonstrate(task, 3, 12, np.random.default_rng(0), 1)
    return Recipe(task, shown, SMALL, {"kind": "joint_target"}, 50.0, 2, 5, 1)


def test_a_policy_is_trained_and_tried(recipe):
    assert trained(recipe, Cell(256.0, 32.0), 0) in (0.0, 0.5, 1.0)


def test_gains_that_demonstrations_do_not_survive_have_no_success(recipe):
    assert trained(recipe, Cell(2.0, 0.5), 0) == 0.0


def test_what_was_trained_counts_and_goes_on(recipe, tmp_path):
    """Of gains that lift no FR3, so that each is tried in a moment."""
    folder, ranges = dataset(tmp_path / "set"), of_arm.RANGES
    motions = of_dataset(folder, of_arm.PLANT, of_arm.JOINTS, ranges, None, False)
    advice = advised(of_arm.asked(motions))
    path, said = tmp_path / FILE, []
    first = trainings_of(advice, recipe, 1, path, "this", said.append)
    assert first.tried[0].cell == advice.best
    assert "0 % succeed" in said[-1]
    text = path.read_text()
    assert trainings_of(advice, recipe, 1, path, "this").tried == first.tried
    assert path.read_text() == text
    more = trainings_of(advice, recipe, 3, path, "this")
    assert more.tried[:1] == first.tried
    assert len(begun(path, "this")) == 3
    changed = settled(advice, more)
    assert changed.best != advice.best
    assert changed.allowed[changed.cells, np.arange(2)].all()
    assert changed.as_good[changed.best]
    with pytest.raises(ConfigurationError, match="found trainings of this; allowed: of that"):
        trainings_of(advice, recipe, 3, path, "that")
