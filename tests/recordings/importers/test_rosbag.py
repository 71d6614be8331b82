"""Bags are written here by rosbags itself, in both of its formats."""

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


def write_bag(path, kind="numbers", plugin="MCAP", jitter_ns=3_000_000, names=ORDER, repeated=()):
    """One second of states at 100 Hz, received late, and commands at 50 Hz.

    States and commands of the numbers `repeated` have the stamp of those before them.
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
            message = state(
                header=stamped(ns), name=list(names), position=q, velocity=none, effort=2 * q
            )
            late = ns + int(rng.integers(0, jitter_ns))
            writer.write(states, late, store.serialize_cdr(message, state.__msgtype__))
            if i % 2 == 0:
                values = np.array([0.1 + i / 100, 0.2])
                ns -= (i in repeated) * 10_000_000
                if kind == "numbers":
                    message = numbers(layout=layout, data=values)
                else:
                    after = types["builtin_interfaces/msg/Duration"](sec=0, nanosec=20_000_000)
                    message = trajectory(
                        header=stamped(ns), joint_names=["arm_b", "arm_a"],
                        points=[target(positions=values[::-1].copy(), velocities=none,
                                       accelerations=none, effort=none, time_from_start=after)],
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
    assert "topic /joint_states: 1 messages left out" in caplog.text
    assert "topic /command: 1 messages left out" in caplog.text
    at = ~np.isnan(recording.q[:, 0])
    assert at.sum() == 99
    row = np.searchsorted(recording.time, 0.4901, side="right") - 1
    assert recording.q[row] == pytest.approx([0.5, 1.0])
    assert recording.q_des[row] == pytest.approx([0.6, 0.2])
