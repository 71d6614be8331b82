import numpy as np
import pytest
import yaml

from t2l.errors import CameraError
from t2l.tasks import make_task
from t2l.tasks.cameras import Cameras
from tests.conftest import ROOT

NAMES = ["global", "wrist"]


@pytest.fixture(scope="module")
def starts(task):
    return task.sample_starts(np.random.default_rng(0), 3)


@pytest.fixture(scope="module")
def cameras(task):
    with Cameras(task.spec(visual=True).compile(), NAMES, 32) as cameras:
        yield cameras


def test_the_same_state_is_the_same_bytes_alone_and_in_a_batch(cameras, task, starts):
    batch = cameras.pictures(starts)
    assert batch.shape == (3, *cameras.shape) == (3, 2, 32, 32, 3)
    assert batch.dtype == np.uint8
    for position, pictures in zip(starts[::-1], batch[::-1], strict=True):
        np.testing.assert_array_equal(cameras.pictures(position[None])[0], pictures)
    with Cameras(task.spec(visual=True).compile(), NAMES[1:], 32) as wrist:
        np.testing.assert_array_equal(wrist.pictures(starts)[:, 0], batch[:, 1])


def test_both_cameras_see_a_block_that_moves(cameras, task, starts):
    moved = starts[:1].copy()
    at = task.model.joint("red_block").qposadr[0]
    moved[:, at : at + 2] += 0.04
    changed = (cameras.pictures(moved) != cameras.pictures(starts[:1])).any(axis=(0, 2, 3, 4))
    assert changed.tolist() == [True, True]


@pytest.mark.parametrize("name", ["block_stack_ur5e", "dishwasher"])
def test_every_task_at_the_table_has_them(name):
    parameters = yaml.safe_load((ROOT / f"config/tasks/{name}.yaml").read_text())
    assert {"overview", *NAMES} <= set(make_task(parameters).cameras)


def test_a_camera_that_is_not_there_is_named_with_those_that_are(task):
    with pytest.raises(CameraError, match="found 'rist'; allowed: overview, global, wrist"):
        Cameras(task.spec(visual=True).compile(), ["rist"], 32)


def test_a_machine_without_opengl_is_told(task, monkeypatch):
    def none(*arguments):
        raise RuntimeError("no display")

    monkeypatch.setattr("mujoco.Renderer", none)
    with pytest.raises(CameraError, match=r"pictures need OpenGL.*no display"):
        Cameras(task.spec(visual=True).compile(), NAMES, 32)
