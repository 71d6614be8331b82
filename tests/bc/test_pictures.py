"""From demonstrations by pictures to rollouts, at the smallest size."""

import numpy as np
import pytest

from t2l.actions import make_control
from t2l.bc.rollout import roll_out
from t2l.bc.training import train, views_of
from t2l.demos.episodes import write_episodes
from t2l.demos.pictures import render, write_pictures
from t2l.demos.replay import replay
from t2l.errors import ArtefactError
from t2l.gains import Cell
from t2l.tasks import make_task
from t2l.tasks.cameras import Cameras

CELL, STEPS = Cell(128, 8), 50
SETTINGS = {
    "policy": "chunk_regression", "validation_fraction": 0.3, "hidden": [16], "history": 2,
    "chunk": 2, "epochs": 1, "batch_size": 16,
}  # fmt: skip


def control(task):
    return make_control({"kind": "joint_target"}, CELL, task.robot, task.model)


@pytest.fixture(scope="module")
def cameras(task):
    with Cameras(task.spec(visual=True).compile(), ["global", "wrist"], 16) as cameras:
        yield cameras


def test_policies_that_see_are_trained_and_rolled_out(
    task, block_stack, demonstrations, cameras, tmp_path
):
    shown, kept = demonstrations[:4], [0, 2, 3]
    write_pictures(render(shown, cameras, STEPS, "mean"), cameras, task, 10, tmp_path / "pictures")
    replays = replay(task, shown, control(task), STEPS)
    # one that does not survive leaves its pictures unused
    write_episodes([replays[i].episode for i in kept], tmp_path / "episodes.parquet", kept)
    views = views_of(tmp_path / "pictures", cameras.names, cameras.size_px)
    arguments = ([0], (0, "train", "block_stack"), control(task).actions.names, None, SETTINGS)
    data = {CELL: tmp_path / "episodes.parquet"}
    ((policy, losses),) = train(task, data, *arguments, views=views)
    # what others see of the blocks is not there for it
    assert policy.observation_size == task.robot_observation_size
    assert np.isfinite(losses.validation_mse_rad2).all()

    asked = []

    def act(history, pictures):
        asked.append((history, pictures))
        return policy.act(history, pictures)

    short = make_task({**block_stack, "horizon_s": 0.8})
    starts = np.stack([d.qpos[0] for d in shown[:3]])
    rollouts = roll_out(short, act, 2, 2, control(short), starts, STEPS, cameras=cameras)
    assert len(rollouts.table) == 3
    # eight ticks, of which the policy decides at every other one
    assert len(asked) == 4
    for k, (history, pictures) in enumerate(asked):
        assert history.shape == (3, 2, task.robot_observation_size)
        np.testing.assert_array_equal(pictures, cameras.pictures(rollouts.qpos[2 * k]))


def test_pictures_of_other_steps_are_told(task, demonstrations, cameras, tmp_path):
    shown = demonstrations[:2]
    write_pictures(render(shown, cameras, 100, "mean"), cameras, task, 5, tmp_path / "pictures")
    replays = replay(task, shown, control(task), STEPS)
    write_episodes([r.episode for r in replays], tmp_path / "episodes.parquet")
    views = views_of(tmp_path / "pictures", cameras.names, cameras.size_px)
    data = {CELL: tmp_path / "episodes.parquet"}
    with pytest.raises(ArtefactError, match="steps of demonstration 0; expected the same steps"):
        list(train(task, data, [0], (0, "a", "b"), ["q"], None, SETTINGS, views=views))
