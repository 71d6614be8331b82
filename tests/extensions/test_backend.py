"""A back end of the user's: recorded from, identified, and deployed to."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from t2l.actions import ACTIONS
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.hardware import BACKENDS, BackendError, open_backend
from t2l.hardware.identification_motion import identification_motion
from t2l.hardware.plan import read_plan
from t2l.hardware.recorder import record_plan
from t2l.identify.actuators import identify
from t2l.recordings import read_recording
from t2l.robots import make_robot
from t2l.transfer.deploy import deploy
from t2l.transfer.identified import IdentifiedRobot
from tests.defaults import WORKSPACE, identification, shipped
from tests.hardware.made import Proportional

CELL = Cell(128, 16)
SECTION = {"name": "fr3", "backend": "echo", "lag_s": 0.05}
PLAN = {
    "backend": "echo", "robot": "fr3", "gains": {"kp": 64, "kd": 4},
    "excitation": {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 1},
}  # fmt: skip


def plan(folder, **changes):
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump(PLAN | changes))
    return read_plan(path)


def test_it_is_identified_and_deployed_to():
    robot = make_robot("fr3")
    with open_backend(SECTION, robot) as arm:
        recording = arm.record(identification_motion(robot, CELL, 0.1, 4))
    assert recording.notes == "an echo after 0.05 s"
    # it measures none
    assert recording.tau is None
    found = identify(recording, identification(iterations=2, population=4), seed=0)
    task, policy = shipped("joint_reach"), Proportional(len(robot.joints))
    names = [f"q_des.{joint}" for joint in robot.joints]
    actions = ACTIONS.find("joint_delta")(names, 0.2, robot.position_limit)
    starts = np.tile(robot.home, (2, 1))
    rest = (policy, task, actions, CELL, starts, starts + 0.1, 50.0, 1.0, WORKSPACE)
    # more are asked for than it has
    with open_backend(SECTION, robot, 30) as arm:
        real = deploy(arm, *rest)
    with open_backend(SECTION, robot, 9) as arm:
        assert arm.n == 1
    assert real.success.all()
    assert real.stopped == ("", "")
    simulated = deploy(IdentifiedRobot(robot, 2, found.parameters, 100), *rest)
    assert simulated.q.shape == real.q.shape


def test_it_records_a_plan_of_any_robot(tmp_path):
    made = plan(tmp_path, robot="three_joint_arm", lag_s=0.02)
    (table,) = record_plan(made, tmp_path / "out", report=lambda line: None)
    recording = read_recording(table)
    assert recording.joints == ("turn", "lift", "bend")
    # of a slow sine, the lag times its greatest velocity, and a period that commands are held for
    late = 0.1 * 2 * np.pi * (0.02 + 0.02 / 2)
    assert np.abs(recording.q - recording.q_des).max() == pytest.approx(late, rel=0.2)


def test_one_that_stops_answering_is_told_and_nothing_half_written(tmp_path):
    class Deaf(BACKENDS.find("echo")):
        sent = 0

        def send(self, q_des, period_s):
            self.sent += 1
            # 20 ticks of each command
            if self.sent > 50 * 20:
                raise BackendError("found no answer; allowed: an answer within a second")
            super().send(q_des, period_s)

    with pytest.raises(BackendError, match=r"plan.yaml: kp64_kd4, 1.00 s: found no answer"):
        record_plan(replace(plan(tmp_path), backend=Deaf), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_one_that_is_measured_beyond_a_limit_is_stopped_and_nothing_half_written(tmp_path):
    """It is so quick that it jumps to each command, which no model knows."""
    held = []

    class Held(BACKENDS.find("echo")):
        def hold(self):
            held.append(True)

    quick = replace(plan(tmp_path, lag_s=0.002), backend=Held)
    beyond = (
        r"plan.yaml: kp64_kd4, 0.\d\d s: .* stopped: found velocity of fr3_joint\d .* rad/s; all"
    )
    with pytest.raises(BackendError, match=beyond):
        record_plan(quick, tmp_path / "out")
    assert held
    assert not (tmp_path / "out").exists()


def test_a_key_that_it_does_not_have_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"key lag: found an unknown key .*mean lag_s"):
        plan(tmp_path, lag=1)
    with pytest.raises(ConfigurationError, match=r"config: robot.lag_s: found -1; allowed: a numb"):
        open_backend(SECTION | {"lag_s": -1}, make_robot("fr3"))
