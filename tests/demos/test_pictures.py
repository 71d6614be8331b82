import json
import os
import shutil
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from t2l.actions import make_control
from t2l.demos.dataset import write_dataset
from t2l.demos.pictures import read_pictures, render, write_pictures
from t2l.demos.replay import replay
from t2l.demos.retarget import replayed
from t2l.errors import ArtefactError, CameraError
from t2l.gains import Cell
from t2l.tasks.cameras import Cameras

NAMES, SIZE = ["global", "wrist"], 24

READ_WITH_LEROBOT = """
import sys
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

folder, expected = sys.argv[1:]
dataset = LeRobotDataset("t2l/block_stack", root=folder)
assert "observation.environment_state" not in dataset.meta.features
assert dataset.meta.camera_keys == ["observation.images.global", "observation.images.wrist"]
frame = dataset[3]
seen = np.stack([frame[key].numpy() for key in dataset.meta.camera_keys])
pictures = np.load(expected).transpose(0, 3, 1, 2) / 255
np.testing.assert_allclose(seen, pictures, atol=1e-6)
print(frame["observation.state"].shape, frame["action"].shape)
"""


@pytest.fixture(scope="module")
def cameras(task):
    with Cameras(task.spec(visual=True).compile(), NAMES, SIZE) as cameras:
        yield cameras


@pytest.fixture(scope="module")
def seen(demonstrations, cameras):
    return list(render(demonstrations[:2], cameras, 50, "mean"))


@pytest.fixture(scope="module")
def stored(seen, cameras, task, tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "pictures"
    write_pictures(seen, cameras, task, 10, path)
    return path


def test_pictures_survive_the_disk_to_the_last_bit(seen, stored):
    store, frames = read_pictures(stored, NAMES, SIZE)
    for written, index in zip(seen, frames, strict=True):
        np.testing.assert_array_equal(store[index], written)
    only, _ = read_pictures(stored, NAMES[1:], SIZE)
    np.testing.assert_array_equal(only[:, 0], store[:, 1])


def test_lerobot_reads_what_a_cell_is_trained_on(task, demonstrations, stored, tmp_path):
    control = make_control({"kind": "joint_target"}, Cell(128, 8), task.robot, task.model)
    episodes = [r.episode for r in replay(task, demonstrations[:2], control, 50)]
    store, frames = read_pictures(stored, NAMES, SIZE)
    np.save(tmp_path / "expected.npy", store[3])
    pictures = (store[index] for index in frames)
    path = tmp_path / "set"
    write_dataset(episodes, task, control.actions.names, 10, path, NAMES, SIZE, pictures)
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", READ_WITH_LEROBOT, str(path), str(tmp_path / "expected.npy")],
        capture_output=True, text=True, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert "(24,)" in done.stdout or "[24]" in done.stdout


@pytest.mark.parametrize("how", ["mean", "sample"])
@pytest.mark.parametrize("cell", [Cell(32, 2), Cell(2048, 128)], ids=str)
def test_a_demonstration_is_where_its_replays_are(task, demonstrations, cell, how):
    """So pictures of it are theirs."""
    control = make_control({"kind": "joint_target"}, cell, task.robot, task.model)
    block = list(task.observation_names).index("red_block.x")
    for d, r in zip(demonstrations, replay(task, demonstrations, control, 10, how), strict=True):
        shown = replayed(d, 10, how)
        assert len(shown) == len(r.observation)
        assert np.abs(shown[:, task.arm_qpos] - r.observation[:, :7]).max() < 5e-3
        where = task.block_poses(shown)[:, 0, :3]
        assert np.abs(where - r.observation[:, block : block + 3]).max() < 5e-3


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (
            {"pos": (-0.6, 0.5, 0.05), "zaxis": (0, 0, 1)},
            "found pictures of one colour",
        ),
        ({"pos": (-1, 0, 0.5), "zaxis": (1, 0, 0)}, "found the same picture all along"),
    ],
    ids=["of the bare table", "away from the robot"],
)
def test_a_camera_that_sees_nothing_is_named(task, demonstrations, pose, message):
    spec = task.spec(visual=True)
    camera = spec.worldbody.add_camera(name="blind", pos=pose["pos"])
    camera.alt.type = mujoco.mjtOrientation.mjORIENTATION_ZAXIS
    camera.alt.zaxis = pose["zaxis"]
    box = {"type": mujoco.mjtGeom.mjGEOM_BOX, "contype": 0, "conaffinity": 0}
    red = (0.8, 0.1, 0.1, 1)
    spec.worldbody.add_geom(size=(0.2, 0.2, 0.2), pos=(-3, 0.3, 0.5), rgba=red, **box)
    with (
        Cameras(spec.compile(), ["blind"], SIZE) as blind,
        pytest.raises(CameraError, match=f"camera blind: {message} in demo"),
    ):
        list(render(demonstrations[:1], blind, 50, "mean"))


def test_pictures_that_a_policy_asks_for_and_that_are_not_there_are_named(stored, tmp_path):
    with pytest.raises(ArtefactError, match=r"lacks 'observation.images.overview'"):
        read_pictures(stored, ["global", "overview"], SIZE)
    with pytest.raises(ArtefactError, match=r"observation.images.global has shape \[24, 24, 3\]"):
        read_pictures(stored, NAMES, 32)
    with pytest.raises(ArtefactError, match="no such folder"):
        read_pictures(tmp_path / "none", NAMES, SIZE)
    broken = tmp_path / "broken"
    shutil.copytree(stored, broken)
    info = broken / "meta/info.json"
    content = json.loads(info.read_text())
    info.write_text(json.dumps(content | {"total_frames": content["total_frames"] + 1}))
    with pytest.raises(ArtefactError, match="frames"):
        read_pictures(broken, NAMES, SIZE)
