"""Bags are written here by rosbags itself, in both of its formats."""

import os

import numpy as np
import pytest
import yaml

from t2l.errors import RecordingError
from t2l.recordings.importers import read_bag, read_bag_mapping

pytest.importorskip("rosbags")

BEGIN = 1_700_000_000_000_000_000  # ns since 1970
MAPPING = {
    "robot": "fr3", "joints": ["a", "b"], "kp": 10, "kd": 1, "command_rate_hz": 50,
    "control_rate_hz": 1000, "gravity_compensation": True,
    "topics": {"state": "/joint_states", "command": "/command"}, "names": ["arm_a", "arm_b"],
}  # fmt: skip
# the driver publishes other joints too, in an order of its own
ORDER = ["finger", "arm_b", "arm_a"]


def write_bag(
    path, kind="numbers", plugin="MCAP", jitter_ns=3_000_000, names=ORDER, repeated=(),
    clock=lambda i, ns: ns, times=((0, 20_000_000),), without=(),
):  # fmt: skip
    """One second of states at 100 Hz, received late, and commands at 50 Hz.

    States and commands of the numbers `repeated` have the stamp of those before them.

    Args:
        clock: the stamp of a header, by the state's number and its time.
        times: s and ns from the start of each point of a trajectory.
        without: numbers of the commands that have no points.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    state, numbers = types["sensor_msgs/msg/JointState"], types["std_msgs/msg/Float64MultiArray"]
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    trajectory = types["trajectory_msgs/msg/JointTrajectory"]
    target = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    none = np.zeros(0)

    def stamped(ns):
        return header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="")

    rng = np.random.default_rng(0)
    with Writer(path, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
        states = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        command = numbers if kind == "numbers" else trajectory
        commands = writer.add_connection("/command", command.__msgtype__, typestore=store)
        for i in range(100):
            ns = BEGIN + (i - (i in repeated)) * 10_000_000
            q = np.array([9.0, 0.02 * i, 0.01 * i])
            head = stamped(clock(i, ns))
            message = state(header=head, name=list(names), position=q, velocity=none, effort=2 * q)
            late = ns + int(rng.integers(0, jitter_ns))
            writer.write(states, late, store.serialize_cdr(message, state.__msgtype__))
            if i % 2 == 0:
                values = np.array([0.1 + i / 100, 0.2])
                ns -= (i in repeated) * 10_000_000
                if kind == "numbers":
                    message = numbers(layout=layout, data=values)
                else:
                    after = types["builtin_interfaces/msg/Duration"]
                    message = trajectory(
                        header=stamped(clock(i, ns)), joint_names=["arm_b", "arm_a"],
                        points=[target(positions=values[::-1].copy(), velocities=none,
                                       accelerations=none, effort=none,
                                       time_from_start=after(sec=s, nanosec=n))
                                for s, n in times if i not in without],
                    )  # fmt: skip
                writer.write(commands, ns, store.serialize_cdr(message, command.__msgtype__))
    return path


def mapping(folder, **changes):
    path = folder / "mapping.yaml"
    path.write_text(yaml.safe_dump({**MAPPING, **changes}))
    return read_bag_mapping(path)


@pytest.mark.parametrize("plugin", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize("kind", ["numbers", "trajectory"])
def test_a_bag_becomes_a_recording_by_the_stamps_of_its_headers(tmp_path, kind, plugin):
    recording = read_bag(write_bag(tmp_path / "run", kind, plugin), mapping(tmp_path))
    assert recording.joints == ("a", "b")
    assert recording.name == "run"
    at = ~np.isnan(recording.q[:, 0])
    assert at.sum() == 100
    assert recording.time[at] == pytest.approx(np.arange(100) / 100, abs=1e-6)
    assert recording.q[at] == pytest.approx(np.outer(np.arange(100) / 100, [1.0, 2.0]))
    assert recording.tau[at] == pytest.approx(2 * recording.q[at])
    assert recording.dq is None
    row = np.searchsorted(recording.time, 0.5001, side="right") - 1
    assert recording.q_des[row] == pytest.approx([0.6, 0.2])


def test_an_mcap_file_alone_is_enough(tmp_path):
    bag = write_bag(tmp_path / "run")
    (file,) = bag.glob("*.mcap")
    assert len(read_bag(file, mapping(tmp_path)).time) == 100


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"topics": {"state": "/joint_state", "command": "/command"}}, "joint_states"),
        ({"topics": {"state": "/command", "command": "/command"}}, "sensor_msgs/msg/JointState"),
        ({"names": ["arm_a", "arm_c"]}, "joint arm_c: found nothing"),
        ({"names": ["arm_a"]}, "key names"),
        ({"topics": {"state": "/joint_states"}}, "key topics.command: found nothing"),
        ({"clock": "ntp"}, "key clock"),
        ({"speed": 1}, "key speed"),
        ({"joints": ["a"], "names": ["arm_a"]}, "2 numbers"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, changes, said):
    bag = write_bag(tmp_path / "run")
    with pytest.raises(RecordingError, match=said):
        read_bag(bag, mapping(tmp_path, **changes))


@pytest.mark.parametrize("cut", [0, 100, 5000])
def test_a_damaged_bag_is_said_to_be_one(tmp_path, cut):
    bag = write_bag(tmp_path / "run")
    (file,) = bag.glob("*.mcap")
    file.write_bytes(file.read_bytes()[:cut])
    with pytest.raises(RecordingError, match="the bag: found what cannot be read"):
        read_bag(file, mapping(tmp_path))


def test_no_bag_at_all(tmp_path):
    with pytest.raises(RecordingError, match="the bag: found nothing"):
        read_bag(tmp_path / "nothing.mcap", mapping(tmp_path))


@pytest.mark.parametrize("kind", ["numbers", "trajectory"])
def test_of_messages_with_one_stamp_the_last_counts(tmp_path, kind, caplog):
    recording = read_bag(write_bag(tmp_path / "run", kind, repeated=[50]), mapping(tmp_path))
    assert "topic /joint_states: 1 of 100 messages left out" in caplog.text
    assert "topic /command: 1 of 50 messages left out" in caplog.text
    at = ~np.isnan(recording.q[:, 0])
    assert at.sum() == 99
    row = np.searchsorted(recording.time, 0.4901, side="right") - 1
    assert recording.q[row] == pytest.approx([0.5, 1.0])
    assert recording.q_des[row] == pytest.approx([0.6, 0.2])


HOUR = 3600 * 10**9


@pytest.mark.parametrize("kind", ["numbers", "trajectory"])
def test_a_clock_that_is_set_back_is_refused(tmp_path, kind):
    bag = write_bag(tmp_path / "run", kind, clock=lambda i, ns: ns - HOUR * (i >= 50))
    said = "topic /.*, message .*: found a stamp 3600 s before that of an earlier message"
    with pytest.raises(RecordingError, match=said):
        read_bag(bag, mapping(tmp_path))
    # as it says, the other clock is a way out
    recording = read_bag(bag, mapping(tmp_path, clock="received"))
    assert (~np.isnan(recording.q[:, 0])).sum() == 100


def test_a_clock_that_is_set_ahead_is_said(tmp_path, caplog):
    bag = write_bag(tmp_path / "run", "trajectory", clock=lambda i, ns: ns + HOUR * (i >= 50))
    recording = read_bag(bag, mapping(tmp_path))
    assert "/joint_states: the stamp of message 51 is 3600 s ahead" in caplog.text
    assert recording.duration_s == pytest.approx(3600.99)


def test_messages_that_overtake_each_other_are_put_in_order(tmp_path):
    bag = write_bag(tmp_path / "run", clock=lambda i, ns: ns + 10_000_000 * (1 - 2 * (i % 2)))
    recording = read_bag(bag, mapping(tmp_path))
    q = recording.q[~np.isnan(recording.q[:, 0]), 0]
    assert len(q) == 100
    assert q[:4] == pytest.approx([0.01, 0.0, 0.03, 0.02])


def test_what_lies_outside_the_commands_is_counted(tmp_path, caplog):
    bag = write_bag(tmp_path / "run", "trajectory", without=range(20))
    recording = read_bag(bag, mapping(tmp_path))
    assert "/command: 10 of 50 messages left out, without points" in caplog.text
    assert "/joint_states: 20 of 100 messages left out, from before the first" in caplog.text
    assert (~np.isnan(recording.q[:, 0])).sum() == 80
    caplog.clear()
    bag = write_bag(tmp_path / "late", clock=lambda i, ns: ns - HOUR // 7200)
    read_bag(bag, mapping(tmp_path))
    assert "/joint_states: 50 of 100 messages left out, from before the first" in caplog.text
    assert "/command: 25 of 50 messages left out, from after the last state" in caplog.text


def test_nothing_is_said_where_nothing_is_left_out(tmp_path, caplog):
    read_bag(write_bag(tmp_path / "run"), mapping(tmp_path))
    assert not caplog.text


@pytest.mark.parametrize("times", [(), ((0, 20), (0, 20)), ((1, 0), (0, 20))])
def test_trajectories_that_no_controller_takes_are_told(tmp_path, times):
    bag = write_bag(tmp_path / "run", "trajectory", times=times)
    with pytest.raises(RecordingError, match="/command: found 50 trajectories without points"):
        read_bag(bag, mapping(tmp_path))


@pytest.mark.parametrize("seconds", [1_000_000, 2_000_000_000])
def test_a_point_that_is_far_ahead_is_not_reached(tmp_path, seconds):
    recording = read_bag(
        write_bag(tmp_path / "run", "trajectory", times=[(seconds, 0)]), mapping(tmp_path)
    )
    assert len(recording.time) < 200
    assert np.abs(recording.q_des).max() < 1e-3


def test_stamps_that_span_years_are_refused_at_once(tmp_path):
    bag = write_bag(tmp_path / "run", "trajectory", clock=lambda i, ns: ns - 10**18 * (i < 98))
    with pytest.raises(RecordingError, match=r"first command to the last state: found 1e\+09 s"):
        read_bag(bag, mapping(tmp_path))


@pytest.mark.parametrize("name", ["x.mcap", "metadata.yaml", "run.mcap"])
def test_a_pipe_is_not_waited_for(tmp_path, name):
    bag = tmp_path / name
    if name == "x.mcap":
        os.mkfifo(bag)
    else:
        bag = write_bag(tmp_path / "run")
        (bag / name).unlink()
        os.mkfifo(bag / name)
    with pytest.raises(RecordingError, match=rf"{name}: the file: found a named pipe \(FIFO\)"):
        read_bag(bag, mapping(tmp_path))
