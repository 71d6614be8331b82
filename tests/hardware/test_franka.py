"""aiofranka drives its own simulated robot here, in real time."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import aiofranka
import numpy as np
import pytest
import yaml

from t2l.actions import ACTIONS
from t2l.gains import Cell
from t2l.hardware import BackendError, franka
from t2l.hardware.backend import BeyondLimitError
from t2l.hardware.franka import AiofrankaRobot
from t2l.hardware.guard import Workspace
from t2l.hardware.motion import Motion
from t2l.hardware.plan import read_plan
from t2l.hardware.recorder import record_plan
from t2l.recordings import read_recordings
from t2l.robots import make_robot
from t2l.transfer.deploy import deploy
from tests.defaults import WORKSPACE, shipped
from tests.hardware.made import Proportional

ROBOT = make_robot("fr3")
# where aiofranka's simulation begins
START = np.array([[0, 0, 0, -1.57079, 0, 1.57079, -0.7853]])
FAULT = "libfranka: UDP receive: Timeout"
PLAN = {
    "address": "simulation",
    "start_rad": START[0].tolist(),
    "gains": [{"kp": 256, "kd": 16}, {"kp": 32, "kd": 8}],
    "excitation": {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 1},
}
RUN = """
import sys
from t2l.cli.main import main
main(["record", sys.argv[1], "--out", sys.argv[2]])
"""


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(franka, "SETTLE_S", 0.3)


def write_plan(folder, **changes):
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump({**PLAN, **changes}))
    return path


def lose_connection(arm, monkeypatch, fault=FAULT):
    """As aiofranka leaves it when libfranka hears no more from the robot."""
    monkeypatch.setattr(aiofranka.Controller, "error", property(lambda controller: fault))
    arm.controller.stop()


def failing_in_the_middle(fail):
    """A back end that calls `fail` with itself half a second into a recording."""

    class Failing(AiofrankaRobot):
        recorded = 0

        def log_cycles(self, act, duration_s):
            self.recorded = 1
            return super().log_cycles(act, duration_s)

        def sending(self, q_des, period_s):
            self.recorded += self.recorded > 0
            if self.recorded == 37:
                fail(self)
            yield from super().sending(q_des, period_s)

    return Failing


def test_recordings_of_the_simulated_arm(tmp_path):
    plan = read_plan(write_plan(tmp_path))
    paths = record_plan(plan, tmp_path / "out", report=lambda line: None)
    assert [path.name for path in paths] == ["kp256_kd16.csv", "kp32_kd8.csv"]
    stiff, soft = read_recordings(tmp_path / "out")
    commands = plan.motions[0].q_des
    for recording in (stiff, soft):
        assert recording.robot == "fr3"
        assert recording.control_rate_hz == 1000
        assert recording.gravity_compensation
        assert "sine" in recording.notes
        # commands are those of the plan, at about their rate
        assert np.abs(recording.q_des[:, None] - commands).max(axis=2).min(axis=1).max() < 1e-12
        assert np.median(np.diff(recording.time)) == pytest.approx(0.02, abs=0.004)
        # a busy computer stretches the motion, and never hurries it
        assert 1.5 < recording.duration_s < 6.0
        assert (np.abs(recording.dq) <= ROBOT.velocity_limit).all()
        assert (np.abs(recording.tau) <= ROBOT.torque_limit).all()
        # what was logged is one motion
        middle = recording.dq[1:-1]
        steps = recording.q[2:] - recording.q[:-2]
        span = (recording.time[2:] - recording.time[:-2])[:, None]
        assert np.corrcoef(middle.ravel(), (steps / span).ravel())[0, 1] > 0.95
    # Kd/Kp = 62 ms late, of a sine of 0.63 rad/s: 0.025 rad on average, more by the inertia
    error = np.abs(stiff.q - stiff.q_des)
    assert error.mean() < 0.05
    assert error.mean() < np.abs(soft.q - soft.q_des).mean()
    assert (np.ptp(stiff.q, axis=0) > 0.1).all()


@pytest.mark.parametrize("error", [RuntimeError("reflex"), KeyboardInterrupt()], ids=repr)
def test_an_arm_is_stopped_and_nothing_half_written(tmp_path, error):
    arms, speeds = [], []

    def fail(arm):
        arms.append(arm)
        speeds.append(np.abs(arm.read().dq).max())
        raise error

    class Watched(failing_in_the_middle(fail)):
        def hold(self):
            super().hold()
            speeds.append(np.abs(self.read().dq).max())

    plan = replace(read_plan(write_plan(tmp_path, gains={"kp": 64, "kd": 4})), backend=Watched)
    expected = KeyboardInterrupt if isinstance(error, KeyboardInterrupt) else BackendError
    with pytest.raises(expected):
        record_plan(plan, tmp_path / "out")
    # it is held at once, and once more before it is released
    moving, *braked = speeds
    assert moving > 0.1
    assert len(braked) == 2
    assert max(braked) < 0.02
    assert not arms[0].controller.running
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("fault", "told"), [(FAULT, "UDP receive"), (None, "no error given")])
def test_a_lost_connection_is_told_and_nothing_half_written(tmp_path, monkeypatch, fault, told):
    backend = failing_in_the_middle(lambda arm: lose_connection(arm, monkeypatch, fault))
    plan = replace(read_plan(write_plan(tmp_path, gains={"kp": 64, "kd": 4})), backend=backend)
    with pytest.raises(BackendError, match=rf"plan.yaml: .*loop.* stopped.*{told}"):
        record_plan(plan, tmp_path / "out")
    assert not (tmp_path / "out").exists()


class Slow(type(ROBOT)):
    """An arm whose joints may hardly move."""

    groups = (replace(ROBOT.groups[0], velocity_limit=(0.15,) * len(ROBOT.joints)),)


def test_an_arm_beyond_its_limits_is_stopped_between_two_commands(tmp_path):
    """Each is held for a second, and the arm too fast soon after the last was given."""
    q_des = np.repeat(START, 2, axis=0)
    # of gains 128 and 16 it makes at most 0.19 rad/s, whenever the machine looks
    q_des[1, 6] += 0.024
    gains = [np.full(7, gain) for gain in (128.0, 16.0)]
    speeds = []

    class Watched(AiofrankaRobot):
        def hold(self):
            super().hold()
            speeds.append(np.abs(self.read().dq).max())

    begun = time.perf_counter()
    with Watched(Slow()) as arm:
        # so near that the approach is slow enough
        beyond = r"stuck, 1\.\d\d s: .*stopped: found velocity of fr3_joint7 0\.1\d+ rad/s; .*-0.15"
        with pytest.raises(BeyondLimitError, match=beyond):
            arm.record(Motion("stuck", q_des, 1.0, *gains))
        assert time.perf_counter() - begun < 10
    assert max(speeds) < 0.02


def test_a_request_to_terminate_stops_the_arm(tmp_path):
    path = write_plan(tmp_path, excitation={**PLAN["excitation"], "duration_s": 60})
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", RUN, str(path), str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "MUJOCO_GL": "egl"},
        text=True,
    )
    assert "within all limits" in process.stdout.readline()
    time.sleep(8)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=20)
    # as Ctrl-C ends it, and not the signal itself
    assert process.returncode == 130
    assert not (tmp_path / "out").exists()


def test_a_robot_that_is_not_there_is_named():
    with pytest.raises(BackendError, match=r"key address: found 127.0.0.1, which cannot be reach"):
        AiofrankaRobot(ROBOT, "127.0.0.1")


def joint_delta(scale):
    names = [f"q_des.{joint}" for joint in ROBOT.joints]
    return ACTIONS.find("joint_delta")(names, scale, ROBOT.position_limit)


def test_a_policy_reaches_on_aiofrankas_robot_and_is_stopped_where_it_must(tmp_path):
    task, cell, policy = shipped("joint_reach"), Cell(128, 16), Proportional(len(ROBOT.joints))
    starts, goals = START.repeat(2, axis=0), START.repeat(2, axis=0) + 0.1
    gentle = joint_delta(np.where(ROBOT.proximal, 0.2, 0.04))
    high = Workspace((-0.855, -0.855, 1.0), (0.855, 0.855, 1.19))  # above where the flange is
    with AiofrankaRobot(ROBOT) as arm:
        rest = (50.0, 3.0, WORKSPACE, tmp_path)
        rollouts = deploy(arm, policy, task, gentle, cell, starts, goals, *rest)
        stopped = deploy(arm, policy, task, gentle, cell, starts[:1], goals[:1], 50.0, 1.0, high)
    assert rollouts.success.all()
    assert rollouts.stopped == ("", "")
    # it moved, and rests at the end
    assert np.abs(rollouts.dq).max() > 0.05
    assert np.abs(rollouts.dq[-20:]).max() < 0.05
    assert "measured z of the flange" in stopped.stopped[0]
    with pytest.raises(BackendError):
        arm.send(START, 0.02)


def test_a_lost_connection_loses_no_rollout_that_was_complete(tmp_path, monkeypatch):
    starts, goals = START.repeat(2, axis=0), START.repeat(2, axis=0) + 0.05
    task, actions = shipped("joint_reach"), joint_delta(0.05)

    def reached(arm, policy):
        rest = (50.0, 0.4, WORKSPACE, tmp_path)
        with arm:
            return deploy(arm, policy, task, actions, Cell(128, 16), starts, goals, *rest)

    lost, acts = AiofrankaRobot(ROBOT), []

    class Losing(Proportional):
        def act(self, history):
            acts.append(1)
            if len(acts) == 30:  # in the middle of the second rollout
                lose_connection(lost, monkeypatch)
            return super().act(history)

    with pytest.raises(BackendError, match=r"control loop.* stopped.*UDP receive"):
        reached(lost, Losing(len(ROBOT.joints)))
    assert [kept.name for kept in tmp_path.iterdir()] == ["000.npz"]
    first = tmp_path / "000.npz"
    before = first.stat().st_mtime_ns
    rollouts = reached(AiofrankaRobot(ROBOT), Proportional(len(ROBOT.joints)))
    assert first.stat().st_mtime_ns == before
    assert rollouts.stopped == ("", "")
    assert np.isfinite(rollouts.q).all()
