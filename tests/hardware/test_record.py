"""aiofranka drives its own simulated robot here, in real time."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from t2l.hardware.record import _rows_of_commands, record

from t2l.errors import RecordingError
from t2l.hardware import franka_arm as franka
from t2l.hardware.limits import FR3_VELOCITY_LIMIT
from t2l.hardware.plan import read_plan
from t2l.recordings import read_recordings
from t2l.robots import fr3

PLAN = {
    "address": "simulation",
    # where aiofranka's simulation begins
    "start_rad": [0, 0, 0, -1.57079, 0, 1.57079, -0.7853],
    "gains": [{"kp": 256, "kd": 16}, {"kp": 32, "kd": 8}],
    "excitation": {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 1},
}
RUN = """
import sys
from pathlib import Path
from argparse import Namespace
from t2l.cli import record
record.run(Namespace(config=Path(sys.argv[1]), out=Path(sys.argv[2]), check=False, yes=False))
"""


def write_plan(folder, **changes):
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump({**PLAN, **changes}))
    return path


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(franka, "SETTLE_S", 0.3)


def test_recordings_of_the_simulated_arm(tmp_path):
    plan = read_plan(write_plan(tmp_path))
    lines = []
    paths = record(plan, tmp_path / "out", report=lines.append)
    assert [path.name for path in paths] == ["kp256_kd16.csv", "kp32_kd8.csv"]
    assert [str(path) in line for path, line in zip(paths, lines, strict=True)] == [True, True]
    stiff, soft = read_recordings(tmp_path / "out")
    for recording in (stiff, soft):
        assert recording.robot == "fr3"
        assert recording.control_rate_hz == 1000
        assert recording.gravity_compensation
        assert "sine" in recording.notes
        # commands are those of the plan, at about their rate
        assert np.abs(recording.q_des[:, None] - plan.q_des).max(axis=2).min(axis=1).max() < 1e-12
        assert np.median(np.diff(recording.time)) == pytest.approx(0.02, abs=0.004)
        # a busy computer stretches the motion, and never hurries it
        assert 1.5 < recording.duration_s < 6.0
        assert (np.abs(recording.dq) <= FR3_VELOCITY_LIMIT).all()
        assert (np.abs(recording.tau) <= fr3.TORQUE_LIMIT).all()
        # what was logged is one motion
        middle = recording.dq[1:-1]
        steps = recording.q[2:] - recording.q[:-2]
        span = (recording.time[2:] - recording.time[:-2])[:, None]
        assert np.corrcoef(middle.ravel(), (steps / span).ravel())[0, 1] > 0.95
    # Kd/Kp = 62 ms late, of a sine of 0.63 rad/s: 0.025 rad on average, more by the inertia
    error = np.abs(stiff.q - stiff.q_des)
    assert error.mean() < 0.05
    assert error.mean() < np.abs(soft.q - soft.q_des).mean()
    moved = np.ptp(stiff.q, axis=0)
    assert (moved > 0.1).all()


@pytest.mark.parametrize("error", [RuntimeError("reflex"), KeyboardInterrupt()], ids=repr)
def test_an_arm_is_stopped_and_nothing_half_written(tmp_path, monkeypatch, error):
    plan = read_plan(write_plan(tmp_path, gains={"kp": 64, "kd": 4}))
    controllers, speeds = [], []

    def speed(controller):
        return np.abs(controller.robot.state["qvel"]).max()

    def fail_in_the_middle(arm, q_des, rate_hz, what):
        if what == "kp64_kd4":
            controllers.append(arm.controller)
            arm.controller.q_desired = q_des[37]
            time.sleep(0.15)
            speeds.append(speed(arm.controller))
            raise error

    brake = franka.FrankaArm.brake

    def watched_brake(arm):
        brake(arm)
        speeds.append(speed(arm.controller))

    monkeypatch.setattr(franka.FrankaArm, "follow", fail_in_the_middle)
    monkeypatch.setattr(franka.FrankaArm, "brake", watched_brake)
    expected = KeyboardInterrupt if isinstance(error, KeyboardInterrupt) else RecordingError
    with pytest.raises(expected):
        record(plan, tmp_path / "out")
    moving, braked = speeds
    assert moving > 0.1
    assert braked < 0.02
    assert not controllers[0].running
    assert not (tmp_path / "out").exists()


def lose_connection(controller, fault="libfranka: UDP receive: Timeout"):
    """As aiofranka leaves it when libfranka hears no more from the robot."""
    engine = controller._engine
    engine.__dict__["_failure"] = fault
    engine.running = False
    while controller.running:
        time.sleep(0.001)


@pytest.mark.parametrize(
    ("fault", "told"),
    [("libfranka: UDP receive: Timeout", "UDP receive"), (None, "no error given")],
)
def test_a_lost_connection_is_told_and_nothing_half_written(tmp_path, monkeypatch, fault, told):
    plan = read_plan(write_plan(tmp_path, gains={"kp": 64, "kd": 4}))
    follow = franka.FrankaArm.follow

    def lose_in_the_middle(arm, q_des, rate_hz, what):
        if what == "kp64_kd4":
            follow(arm, q_des[:40], rate_hz, what)
            lose_connection(arm.controller, fault)
        follow(arm, q_des, rate_hz, what)

    monkeypatch.setattr(franka.FrankaArm, "follow", lose_in_the_middle)
    with pytest.raises(RecordingError, match=rf"loop.* stopped.*{told}"):
        record(plan, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_request_to_terminate_stops_the_arm(tmp_path):
    excitation = {**PLAN["excitation"], "duration_s": 60}
    path = write_plan(tmp_path, excitation=excitation)
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
    _, errors = process.communicate(timeout=20)
    assert errors.strip().endswith("KeyboardInterrupt")
    assert not (tmp_path / "out").exists()


def test_a_robot_that_is_not_there_is_named(tmp_path):
    plan = read_plan(write_plan(tmp_path, address="127.0.0.1"))
    with pytest.raises(RecordingError, match=r"plan.yaml: key address: found 127.0.0.1, which can"):
        record(plan, tmp_path / "out")


def test_rows_are_kept_where_commands_change_and_while_they_hold():
    q_des = np.array([0, 0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3.0])[:, None]
    assert _rows_of_commands(q_des, period=3).tolist() == [0, 2, 5, 8, 11, 13]
