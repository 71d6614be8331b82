"""A task and an action space of one's own go through demonstrations, retargeting and rollouts."""

import numpy as np
import pytest

from t2l.actions import make_control
from t2l.bc.rollout import roll_out
from t2l.demos.dataset import read_demonstrations, write_demonstrations
from t2l.demos.episodes import read_episodes, write_episodes
from t2l.demos.expert import demonstrate
from t2l.demos.replay import replay
from t2l.gains import Cell
from tests.defaults import shipped

CELL, CHUNK = Cell(256, 16), 10


@pytest.fixture(scope="module")
def lift(examples):
    return shipped("block_stack", kind="lift", horizon_s=4.0)


@pytest.fixture(scope="module")
def demonstrations(lift):
    return demonstrate(lift, count=2, max_attempts=4, rng=np.random.default_rng(0), threads=2)


@pytest.mark.parametrize("kind", ["joint_target", "joint_velocity"])
def test_what_is_recorded_is_retargeted_stored_and_rolled_out(lift, demonstrations, kind, tmp_path):
    write_demonstrations(demonstrations, lift, tmp_path / "demonstrations")
    stored = read_demonstrations(tmp_path / "demonstrations", lift)
    control = make_control({"kind": kind}, CELL, lift.robot, lift.model)
    replays = replay(lift, stored, control, CHUNK)
    assert all(r.success for r in replays)
    write_episodes([r.episode for r in replays], tmp_path / "episodes.parquet")
    (_, action), *_ = read_episodes(tmp_path / "episodes.parquet", lift)
    asked = iter(range(1000))

    def act(history):
        at = CHUNK * next(asked) + np.arange(CHUNK)
        chunk = action[np.minimum(at, len(action) - 1)].astype(float)
        if kind == "joint_velocity":
            chunk[at >= len(action), :-1] = 0.0
        return chunk[None]

    start = demonstrations[0].qpos[:1]
    table = roll_out(lift, act, 1, CHUNK, control, start, CHUNK).table
    assert table.success.all()
    still = np.tile(
        np.append(start[0, lift.arm_qpos], 0.04) * (kind == "joint_target"), (1, CHUNK, 1)
    )
    table = roll_out(lift, lambda history: still, 1, CHUNK, control, start, CHUNK).table
    assert table.failure.tolist() == ["not_lifted"]
