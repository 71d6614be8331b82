"""A data set under other gains moves the robot as it did under its own."""

import json
import os
import shutil

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.actions import make_control
from t2l.cli.main import main
from t2l.demos.dataset import write_dataset
from t2l.demos.other_gains import Gains, commands
from t2l.demos.replay import replay
from t2l.gains import Cell
from t2l.recordings.importers import read_lerobot_positions
from t2l.sim import make_batch
from t2l.sim.controllers.joint_pd import pd_torque

OWN, OTHER = Cell(64, 16), Cell(512, 4)
STEPS = 10

gains = st.builds(Gains, st.floats(1, 5000), st.floats(0, 500))
numbers = st.floats(-3, 3)


@given(own=gains, other=gains, q_des=numbers, q=numbers, dq=numbers)
def test_the_other_controller_supplies_the_same_torque(own, other, q_des, q, dq):
    q_des, q, dq = (np.array([[x]]) for x in (q_des, q, dq))
    new = commands(q_des, q, dq, own, other)
    torque = pd_torque(q_des, q, dq, own.kp, own.kd)
    given_torque = pd_torque(new, q, dq, other.kp, other.kd)
    np.testing.assert_allclose(given_torque, torque, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(commands(new, q, dq, other, own), q_des, rtol=1e-9, atol=1e-6)


def control(task, cell):
    return make_control({"kind": "joint_target"}, cell, task.robot, task.model)


@pytest.fixture(scope="module")
def recorded(task, demonstrations, tmp_path_factory):
    """Two demonstrations as a data set that was recorded under gains."""
    folder = tmp_path_factory.mktemp("own") / "recorded"
    replays = replay(task, demonstrations[:2], control(task, OWN), STEPS, how="sample", threads=2)
    names = control(task, OWN).actions.names
    write_dataset([r.episode for r in replays], task, names, 50, folder)
    return folder


def command_line(task, recorded, out, *more, kp=OWN.kp, kd=OWN.kd):
    joints = ",".join(task.robot.joints)
    return [
        *("retarget", str(recorded), "--robot", "fr3", "--joints", joints, "--out", str(out)),
        *("--kp", str(kp), "--kd", str(kd), "--to-kp", str(OTHER.kp), "--to-kd", str(OTHER.kd)),
        *more,
    ]


def moved(task, cell, command, start):
    """Where commands (n, njoint) lead the arm, (n, njoint) rad, at the end of each."""
    batch, controller = make_batch(task.model, 1), control(task, cell).controller
    controller.install(batch)
    task.reset(batch, start)
    went = []
    for target in command:
        controller.step(batch, target[None], np.ones(1, bool), STEPS)
        went.append(batch.qpos[0, task.arm_qpos].copy())
    return np.array(went)


def test_the_robot_moves_as_it_did(task, demonstrations, recorded, tmp_path, capsys):
    main(command_line(task, recorded, tmp_path / "new"))
    assert "2 episodes" in capsys.readouterr().out
    joints, (before, *_) = read_lerobot_positions(recorded, task.robot.joints)
    _, (after, *_) = read_lerobot_positions(tmp_path / "new", joints)
    start = demonstrations[0].qpos[:1]
    there = before[2][1:]

    def error(command):
        return np.sqrt(np.mean((moved(task, OTHER, command, start)[:-1] - there) ** 2))

    # half the time that a command is held goes by before its torque is the right one
    assert error(after[1]) < 0.02
    assert error(before[1]) > 10 * error(after[1])


def test_all_but_the_commands_is_as_it_was_and_statistics_follow(task, recorded, tmp_path):
    main(command_line(task, recorded, tmp_path / "new"))
    tables = [
        pq.read_table(next((folder / "data").glob("*/*.parquet")))
        for folder in (recorded, tmp_path / "new")
    ]
    old, new = tables
    assert new.drop_columns(["action"]).equals(old.drop_columns(["action"]))
    action = np.stack(new["action"].to_numpy())
    # the gripper's command
    np.testing.assert_array_equal(action[:, -1], np.stack(old["action"].to_numpy())[:, -1])
    stats = json.loads((tmp_path / "new/meta/stats.json").read_text())
    np.testing.assert_allclose(stats["action"]["max"], action.max(axis=0), rtol=1e-6)
    by_episode = pq.read_table(next((tmp_path / "new/meta/episodes").glob("*/*.parquet")))
    first = np.array(new["episode_index"]) == 0
    np.testing.assert_allclose(
        by_episode["stats/action/min"][0].as_py(), action[first].min(axis=0), rtol=1e-6
    )


def damaged(recorded, folder, fps):
    shutil.copytree(recorded, folder)
    path = folder / "meta/info.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"fps": fps}))
    return folder


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"kp": 64000}, "without them torques cannot be reconstructed"),
        ({"kp": 0}, "--kp: found 0.0; allowed: one number above 0"),
        ({"kd": -1}, "--kd: found -1.0; allowed: one number from 0 up"),
    ],
)
def test_gains_that_it_was_not_recorded_under_are_refused(task, recorded, tmp_path, change, said):
    with pytest.raises(SystemExit) as error:
        main(command_line(task, recorded, tmp_path / "new", **change))
    assert said in str(error.value)
    assert not (tmp_path / "new").exists()


def test_commands_that_are_held_too_long_are_refused(task, recorded, tmp_path):
    slow = damaged(recorded, tmp_path / "slow", 10)
    with pytest.raises(SystemExit, match="key fps: found 10; allowed: 20 or more"):
        main(command_line(task, slow, tmp_path / "new"))


def spoilt(recorded, folder, key, joint, value, count=1):
    """A copy with a value in place of the first frames' of a joint."""
    shutil.copytree(recorded, folder)
    path = next((folder / "data").glob("*/*.parquet"))
    table = pq.read_table(path)
    rows = np.stack(table[key].to_numpy())
    rows[:count, joint] = value
    field = table.schema.field(key)
    at = table.column_names.index(key)
    pq.write_table(table.set_column(at, field, pa.array(rows.tolist(), field.type)), path)
    return folder


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        # of one frame no torque is looked at
        ("action", 1e30, r"episode 0, frame 0, joint .*joint2: found a command of 1e\+30 rad"),
        ("action", -20.0, "found a command of -20 rad; allowed: -8.067"),
        ("observation.state", 1e30, r"joint2: found a position of 1e\+30 rad; allowed: -1.8"),
        ("observation.state", 3.0, "joint2: found a position of 3 rad; allowed: -1.8.* to 1.8"),
    ],
)
def test_a_frame_where_no_joint_can_be_is_named(task, recorded, tmp_path, key, value, said):
    bad = spoilt(recorded, tmp_path / "bad", key, 1, value)
    with pytest.raises(SystemExit, match=said):
        main(command_line(task, bad, tmp_path / "new"))
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("meta/stats.json", "{", "stats.json: the file: found what is not JSON"),
        ("meta/stats.json", "[]", "stats.json: the file: found no object"),
        ("meta/episodes/chunk-000/file-000.parquet", "x", "file-000.parquet: cannot be read"),
        ("meta/more", None, r"meta/more: the file: found a named pipe \(FIFO\)"),
    ],
)
def test_what_cannot_be_copied_along_is_named_first(
    task, recorded, tmp_path, name, content, said
):  # fmt: skip
    bad = shutil.copytree(recorded, tmp_path / "bad")
    (bad / name).unlink(missing_ok=True)
    if content is None:
        os.mkfifo(bad / name)
    else:
        (bad / name).write_text(content)
    with pytest.raises(SystemExit, match=said):
        main(command_line(task, bad, tmp_path / "new"))
    assert not (tmp_path / "new").exists()


def test_a_data_set_is_not_written_over_itself(task, recorded):
    with pytest.raises(SystemExit):
        main(command_line(task, recorded, recorded))
    assert len(read_lerobot_positions(recorded, task.robot.joints)[1]) == 2
