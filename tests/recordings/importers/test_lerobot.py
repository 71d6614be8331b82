import json
import os
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from t2l.actions import make_control
from t2l.cli.main import main
from t2l.demos.dataset import write_dataset
from t2l.demos.replay import replay
from t2l.errors import InputError, RecordingError
from t2l.gains import Cell
from t2l.recordings import read_recording
from t2l.recordings.importers import read_lerobot, read_lerobot_positions

JOINTS = ["shoulder", "elbow"]
CONTROLLER = {
    "robot": "fr3",
    "joints": JOINTS,
    "kp": 30,
    "kd": 2,
    "control_rate_hz": 1000,
    "gravity_compensation": False,
}
FPS = 30
FRAMES = (40, 25)


def motion(episode):
    """Commanded and measured degrees of an episode, (n, 2)."""
    time = np.arange(FRAMES[episode]) / FPS
    action = np.stack([20 * np.sin(3 * time + episode), 90 + 5 * np.cos(time)], axis=1)
    return action.astype(np.float32), (action - 1).astype(np.float32)


def floats(rows):
    return pa.array([row.tolist() for row in rows], pa.list_(pa.float32()))


@pytest.fixture
def dataset(tmp_path):
    """A data set of two episodes in two files, with a gripper between the joints of its state."""
    folder = tmp_path / "reach"
    names = {
        "action": ["shoulder.pos", "elbow.pos"],
        "observation.state": ["shoulder.pos", "gripper.pos", "elbow.pos"],
    }
    features = {
        key: {"dtype": "float32", "shape": [len(n)], "names": n} for key, n in names.items()
    }
    info = {"codebase_version": "v3.0", "fps": FPS, "features": features, "total_frames": 65}
    (folder / "meta").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    for episode, n in enumerate(FRAMES):
        action, state = motion(episode)
        table = {
            "action": floats(action),
            "observation.state": floats(np.insert(state, 1, 7, axis=1)),
            "episode_index": np.full(n, episode),
            "frame_index": np.arange(n),
        }
        path = folder / "data" / "chunk-000" / f"file-{episode:03d}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.table(table), path)
    return folder


def test_each_episode_becomes_a_recording_in_radians(dataset):
    recordings = read_lerobot(dataset, CONTROLLER, degrees=True)
    assert [r.name for r in recordings] == ["reach_0000", "reach_0001"]
    for episode, recording in enumerate(recordings):
        action, state = motion(episode)
        np.testing.assert_allclose(recording.q_des, np.deg2rad(action.astype(float)))
        np.testing.assert_allclose(recording.q, np.deg2rad(state.astype(float)))
        np.testing.assert_allclose(np.diff(recording.time), 1 / FPS)
        assert recording.command_rate_hz == FPS
        assert recording.kp.tolist() == [30, 30]
        assert recording.dq is None


def test_the_command_writes_chosen_episodes(dataset, tmp_path, capsys):
    line = [
        *("import-lerobot", str(dataset), "--out", str(tmp_path / "out"), "--robot", "fr3"),
        *("--joints", "j1,j2", "--kp", "30,20", "--kd", "2", "--control-rate-hz", "500"),
        *("--gravity-compensation", "no", "--degrees", "--episodes", "1", "--format", "parquet"),
        *("--action-indices", "1,0", "--state-indices", "2,0"),
    ]
    main(line)
    path = tmp_path / "out" / "reach_0001.parquet"
    assert capsys.readouterr().out == f"{path}\n"
    recording = read_recording(path)
    action, state = motion(1)
    assert recording.joints == ("j1", "j2")
    assert recording.kp.tolist() == [30, 20]
    np.testing.assert_allclose(recording.q_des, np.deg2rad(action[:, ::-1].astype(float)))
    np.testing.assert_allclose(recording.q, np.deg2rad(state[:, ::-1].astype(float)))


def test_data_sets_that_lerobot_writes_are_read(task, demonstrations, tmp_path):
    control = make_control({"kind": "joint_target"}, Cell(128, 8), task.robot, task.model)
    replays = replay(task, demonstrations[:2], control, decimation=10, threads=2)
    episodes = [r.episode for r in replays]
    write_dataset(episodes, task, control.actions.names, 50, tmp_path / "kp128_kd8")
    controller = {**CONTROLLER, "joints": list(task.robot.joints), "kp": 128, "kd": 8}
    recordings = read_lerobot(tmp_path / "kp128_kd8", controller)
    for r, recording in zip(replays, recordings, strict=True):
        np.testing.assert_allclose(recording.q_des, r.command, atol=1e-6)
        assert np.abs(recording.q - recording.q_des).max() < 1.0
        assert recording.command_rate_hz == 50


def damage_info(folder, **changes):
    path = folder / "meta" / "info.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


def test_names_in_groups_and_no_names_at_all(dataset):
    def with_names(names):
        shape = [len(next(iter(names.values())))] if isinstance(names, dict) else [2]
        action = {"dtype": "float32", "shape": shape, "names": names}
        state = {"dtype": "float32", "shape": [3], "names": ["shoulder", "gripper", "elbow"]}
        damage_info(dataset, features={"action": action, "observation.state": state})

    with_names({"motors": ["elbow", "shoulder"]})
    recording = read_lerobot(dataset, CONTROLLER)[0]
    np.testing.assert_array_equal(recording.q_des, motion(0)[0][:, ::-1])
    with_names(None)
    with pytest.raises(RecordingError, match="found 2 numbers without names; allowed: shoulder"):
        read_lerobot(dataset, CONTROLLER)
    assert len(read_lerobot(dataset, CONTROLLER, action_indices=[0, 1])) == 2


def test_what_is_wrong_is_named(dataset):
    for change, message in (
        ({"joints": ["hip", "elbow"]}, r"features.action: found shoulder.pos, elbow.pos; .* hip"),
        ({"kp": -1}, "key kp: found -1"),
        ({"robot": "so101"}, "key robot: found 'so101'"),
    ):
        with pytest.raises(RecordingError, match=message):
            read_lerobot(dataset, {**CONTROLLER, **change})
    with pytest.raises(RecordingError, match=r"indices into action: found \[0, 2\]; .* 0 to 1"):
        read_lerobot(dataset, CONTROLLER, action_indices=[0, 2])
    with pytest.raises(RecordingError, match=r"episode 5: found nothing; allowed: 0 to 1"):
        read_lerobot(dataset, CONTROLLER, episodes=[5])
    with pytest.raises(InputError, match=r"info.json: the file: found nothing"):
        read_lerobot(dataset / "data", CONTROLLER)


def test_a_damaged_data_set_is_named(dataset):
    damage_info(dataset, total_frames=66)
    with pytest.raises(RecordingError, match="found 65 frames; allowed: the 66"):
        read_lerobot(dataset, CONTROLLER)
    damage_info(dataset, codebase_version="v2.1")
    with pytest.raises(RecordingError, match=r"found 'v2.1'; allowed: v3.0"):
        read_lerobot(dataset, CONTROLLER)
    damage_info(dataset, codebase_version="v3.0")
    file = next(dataset.glob("data/*/*.parquet"))
    file.write_bytes(file.read_bytes()[:-50])
    with pytest.raises(RecordingError, match="found what cannot be read"):
        read_lerobot(dataset, CONTROLLER)
    (dataset / "meta" / "info.json").write_text("{")
    with pytest.raises(InputError, match=r"info.json: the file: found what is not JSON"):
        read_lerobot(dataset, CONTROLLER)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fps": True}, "key fps: found True; allowed: a number"),
        ({"fps": "50"}, "key fps: found '50'; allowed: a number"),
        ({"fps": 0}, "key fps: found 0; allowed: a number above 0"),
        ({"total_frames": "65"}, "key total_frames: found '65'; allowed: an integer"),
        ({"total_frames": True}, "key total_frames: found True; allowed: an integer"),
        ({"total_frames": 65.5}, "key total_frames: found 65.5; allowed: an integer"),
        ({"codebase_version": 3}, "key codebase_version: found 3; allowed: text"),
        ({"features": []}, r"key features: found \[\]; allowed: keys with values"),
        ({"features": {"action": 1}}, "key features.action: found 1; allowed: the keys shape"),
        ({"features": {"action": {"shape": ["2"]}}}, r"features.action.shape\[0\]: found '2'"),
        ({"features": {"action": {"shape": [True]}}}, r"features.action.shape\[0\]: found True"),
        ({"features": {"action": {"shape": [2, 2]}}}, r"features.action.shape: found \(2, 2\)"),
    ],
    ids=str,
)
def test_what_info_says_has_the_types_that_it_should(dataset, change, said):
    damage_info(dataset, **change)
    with pytest.raises(RecordingError, match=f"info.json: {said}" if "key" in said else said):
        read_lerobot(dataset, CONTROLLER)


def spoil(dataset, key, value, frame=3):
    file = min(dataset.glob("data/*/*.parquet"))
    table = pq.read_table(file)
    rows = table[key].to_pylist()
    rows[frame][0] = value
    at = table.column_names.index(key)
    pq.write_table(table.set_column(at, key, pa.array(rows, pa.list_(pa.float32()))), file)


@pytest.mark.parametrize("key", ["action", "observation.state"])
def test_a_frame_that_no_joint_reaches_is_named(dataset, key, tmp_path):
    spoil(dataset, key, 1e30)
    said = r"episode 0, row 4, column .*: found 1e\+30; allowed: numbers up to 100000"
    with pytest.raises(RecordingError, match=said):
        read_lerobot(dataset, CONTROLLER)
    with pytest.raises(RecordingError, match=rf"episode 0, frame 3, {key}: found 1e\+30; .* 5.7e"):
        read_lerobot_positions(dataset)
    with pytest.raises(SystemExit, match="episode 0, frame 3"):
        main(["gains", str(dataset)])


def test_frames_without_a_command_are_counted(dataset, caplog):
    spoil(dataset, "action", np.nan)
    _, ((time, *_), _) = read_lerobot_positions(dataset)
    assert len(time) == FRAMES[0] - 1
    assert "episode 0: 1 of 40 frames left out, without a command" in caplog.text


def test_positions_outside_the_joints_range_are_not_imported(dataset, tmp_path):
    robot = tmp_path / "arm.xml"
    robot.write_text(
        '<mujoco><compiler angle="radian"/><worldbody><body><joint name="shoulder" range="-2 2"/>'
        '<geom size="0.1" mass="1"/><body><joint name="elbow" range="-2 2"/>'
        '<geom size="0.1" mass="1"/></body></body></worldbody></mujoco>'
    )
    line = [
        *("import-lerobot", str(dataset), "--out", str(tmp_path / "out"), "--robot", str(robot)),
        *("--joints", "shoulder,elbow", "--kp", "30", "--kd", "2", "--control-rate-hz", "500"),
        *("--gravity-compensation", "no"),
    ]
    with pytest.raises(SystemExit, match=r"which looks like degrees .*; allowed: -2 to 2 rad"):
        main(line)
    assert not (tmp_path / "out").exists()
    main([*line, "--degrees"])


def test_a_pipe_is_not_waited_for(dataset):
    os.mkfifo(dataset / "data" / "chunk-000" / "file-002.parquet")
    with pytest.raises(RecordingError, match=r"file-002.parquet: the file: found a named pipe"):
        read_lerobot(dataset, CONTROLLER)


def test_lerobot_itself_is_not_imported():
    code = "import sys, t2l.recordings.importers; sys.exit('lerobot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
