"""Bags of ROS 2 and MCAP files, whatever their clocks and messages: no state vanishes unsaid."""

import logging
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.recordings import read_recording
from t2l.recordings.importers.rosbag import BagMappingFile
from tests.fuzz.generate import as_bytes, damaged, spoilt
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import QUIET

pytest.importorskip("rosbags")

BEGIN = 1_700_000_000_000_000_000  # ns since 1970
MAPPING = {
    "robot": "fr3", "joints": ["a", "b"], "kp": 10, "kd": 1, "command_rate_hz": 50,
    "control_rate_hz": 1000, "gravity_compensation": True,
    "topics": {"state": "/states", "command": "/command"},
}  # fmt: skip
NAMES = ["a", "b"]
ODD_NAMES = [["b", "a"], ["a"], [], ["a", "a"], ["x", "y"], ["", "a", "b"], ["a", "b", "é\n"]]
NUMBERS = [0.0, 0.1, float("nan"), float("inf"), 1e30, -1e300]
# ns by which a clock is set, now and then
JUMPS = [-3600 * 10**9, 3600 * 10**9, -(10**18), 10**17, -50_000_000, -200_000_000, 11 * 10**9]
DURATIONS = [(0, 20_000_000), (0, 0), (1_000_000, 0), (2_000_000_000, 0), (-1, 0), (3, 999_999_999)]


@st.composite
def messages(draw) -> dict:
    """What a bag holds: states, commands, and how they are odd."""
    n = draw(st.sampled_from([0, 1, 5, 30, 30, 30, 60]))
    odd = st.dictionaries(st.integers(0, 60), st.just(None), max_size=3)
    jumps = draw(st.dictionaries(st.integers(1, 60), st.sampled_from(JUMPS), max_size=2))
    return {
        "n": n,
        "jumps": draw(st.sampled_from([{}, jumps])),
        "kind": draw(st.sampled_from(["numbers", "trajectory", "state"])),
        "names": {i: draw(st.sampled_from(ODD_NAMES)) for i in draw(odd)},
        "values": {i: draw(st.lists(st.sampled_from(NUMBERS), max_size=3)) for i in draw(odd)},
        "stampless": draw(st.booleans()) and draw(st.booleans()),
        "points": {
            i: draw(st.lists(st.sampled_from(DURATIONS), max_size=3)) for i in draw(odd)
        },
        "commands_too": draw(st.booleans()),
        "plugin": draw(st.sampled_from(["MCAP", "SQLITE3"])),
    }  # fmt: skip


def write(path: Path, made: dict) -> None:
    """A bag of 50 states and 25 commands a second."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = {name.rpartition("/")[2]: kind for name, kind in store.types.items()}
    none = np.zeros(0)

    def stamped(ns):
        seconds = int(np.clip(ns // 10**9, -(2**31), 2**31 - 1))
        return types["Header"](types["Time"](seconds, int(ns % 10**9)), "")

    def state(header, names, values):
        return types["JointState"](header, names, np.array(values, float), none, none)

    def command(i, ns, values):
        if made["kind"] == "numbers":
            return types["Float64MultiArray"](
                types["MultiArrayLayout"]([], 0), np.array(values, float)
            )
        names = made["names"].get(i, NAMES) if made["commands_too"] else NAMES
        if made["kind"] == "state":
            return state(stamped(ns), names, values)
        points = [
            types["JointTrajectoryPoint"](
                np.array(values, float), none, none, none, types["Duration"](s, n)
            )
            for s, n in made["points"].get(i, DURATIONS[:1])
        ]
        return types["JointTrajectory"](stamped(ns), names, points)

    kinds = {"numbers": "Float64MultiArray", "trajectory": "JointTrajectory", "state": "JointState"}
    commanded = types[kinds[made["kind"]]].__msgtype__
    with Writer(path, version=9, storage_plugin=StoragePlugin[made["plugin"]]) as writer:
        states = writer.add_connection("/states", types["JointState"].__msgtype__, typestore=store)
        commands = writer.add_connection("/command", commanded, typestore=store)
        for i in range(made["n"]):
            received = BEGIN + i * 20_000_000
            ns = 0 if made["stampless"] else received
            ns += sum(jump for at, jump in made["jumps"].items() if at <= i)
            values = made["values"].get(i, [0.01 * i, 0.02])
            message = state(stamped(ns), made["names"].get(i, NAMES), values)
            writer.write(states, received, store.serialize_cdr(message, message.__msgtype__))
            if i % 2 == 0:
                given = values if made["commands_too"] else [0.1 + 0.01 * i, 0.0]
                message = command(i, ns, given)
                writer.write(commands, received, store.serialize_cdr(message, commanded))


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("home")
    (home / "sound.yaml").write_text(yaml.safe_dump(MAPPING))
    write(home / "sound", {"n": 60, "jumps": {}, "kind": "numbers", "names": {}, "values": {},
                           "stampless": False, "points": {}, "commands_too": False,
                           "plugin": "MCAP"})  # fmt: skip
    return home


class Said(logging.Handler):
    """How many states were said to be left out."""

    def __init__(self):
        super().__init__()
        self.count = 0

    def emit(self, record):
        found = re.search(r"topic /states: (\d+) of \d+ messages left out", record.getMessage())
        self.count += int(found[1]) if found else 0


@settings(max_examples=40, **QUIET)
@given(data=st.data())
def test_bags(home, data):
    shutil.rmtree(home / "bad", ignore_errors=True)
    made = data.draw(messages())
    write(home / "bad", made)
    broken = data.draw(st.integers(0, 9)) == 0
    if broken:
        file = data.draw(st.sampled_from(sorted((home / "bad").iterdir())))
        file.write_bytes(damaged(data.draw, file.read_bytes()))
    clock = data.draw(st.sampled_from(["header", "received"]))
    (home / "bad.yaml").write_text(yaml.safe_dump({**MAPPING, "clock": clock}))
    said = Said()
    logging.getLogger("t2l").addHandler(said)
    try:
        line = ["import-rosbag", "bad.yaml", "bad", "--out", "out"]
        message = check(lambda: main(line), home, home / "out", ("bad",))
    finally:
        logging.getLogger("t2l").removeHandler(said)
    if message is None and not broken:
        kept = read_recording(home / "out/bad")
        # one that holds no position of ours is a row without any, if it is a row
        told = [made["values"].get(i, [0, 0]) for i in range(made["n"])]
        empty = sum(len(v) != len(made["names"].get(i, NAMES)) or np.isnan(v).any()
                    for i, v in enumerate(told))  # fmt: skip
        full = np.sum(~np.isnan(kept.q).any(axis=1))
        assert full + said.count <= made["n"] <= full + said.count + empty
    shutil.rmtree(home / "out", ignore_errors=True)


@settings(max_examples=40, **QUIET)
@given(data=st.data())
def test_mappings_of_bags(home, data):
    document = data.draw(spoilt(MAPPING, BagMappingFile))
    (home / "bad.yaml").write_bytes(data.draw(as_bytes(document)))
    line = ["import-rosbag", "bad.yaml", "sound", "--out", "out"]
    check(lambda: main(line), home, home / "out", ("bad.yaml", "sound"))
    shutil.rmtree(home / "out", ignore_errors=True)


def test_the_sound_one_runs(home):
    line = ["import-rosbag", "sound.yaml", "sound", "--out", "out"]
    assert check(lambda: main(line), home, home / "out") is None
    assert len(read_recording(home / "out/sound").time) == 60
    shutil.rmtree(home / "out")
