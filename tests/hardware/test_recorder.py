"""Plans recorded through the virtual robot, which takes no time of its own."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from t2l.gains import Cell
from t2l.hardware import BackendError
from t2l.hardware.identification_motion import identification_motion
from t2l.hardware.plan import read_plan
from t2l.hardware.recorder import needed_bytes, record_plan
from t2l.hardware.virtual import VirtualRobot
from t2l.recordings import read_recordings
from t2l.robots import make_robot

PLAN = {
    "backend": "virtual",
    "robot": "fr3",
    "gains": [{"kp": 256, "kd": 16}, {"kp": 32, "kd": 8}],
    "excitation": {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 2, "frequency_hz": 1},
}


def written(folder, **changes):
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump({**PLAN, **changes}))
    return read_plan(path)


def test_a_plan_becomes_recordings(tmp_path):
    plan, lines = written(tmp_path, notes="a test"), []
    paths = record_plan(plan, tmp_path / "out", report=lines.append)
    assert [path.name for path in paths] == ["kp256_kd16.csv", "kp32_kd8.csv"]
    assert [str(path) in line for path, line in zip(paths, lines, strict=True)] == [True, True]
    assert sum(path.stat().st_size for path in paths) < needed_bytes(plan)
    stiff, soft = read_recordings(tmp_path / "out")
    for recording, motion in zip((stiff, soft), plan.motions, strict=True):
        assert recording.robot == "fr3"
        assert recording.control_rate_hz == 1000
        assert recording.gravity_compensation
        assert recording.notes.startswith("a test; excitation: amplitude_rad 0.1, ")
        np.testing.assert_array_equal(recording.q_des, motion.q_des)
        np.testing.assert_array_equal(recording.time, motion.time)
        # a row is measured when its command is given, which cannot act by then
        np.testing.assert_allclose(recording.q[0], plan.robot.home, atol=1e-4)
    error = np.abs(stiff.q - stiff.q_des)
    assert 0.01 < error.mean() < np.abs(soft.q - soft.q_des).mean()


def test_what_was_complete_before_the_robot_broke_is_kept(tmp_path):
    class Breaking(VirtualRobot):
        commands = 0

        def send(self, q_des, period_s):
            self.commands += 1
            if self.commands > 150 * 20:
                raise BackendError("a reflex")
            super().send(q_des, period_s)

    plan = replace(written(tmp_path), backend=Breaking)
    with pytest.raises(BackendError, match=r"plan.yaml: kp32_kd8, 0.98 s: a reflex"):
        record_plan(plan, tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "kp256_kd16.csv", "kp256_kd16.yaml",
    ]  # fmt: skip


def test_whatever_ends_a_recording_the_robot_is_released(tmp_path):
    released = []

    class Interrupted(VirtualRobot):
        def send(self, q_des, period_s):
            raise KeyboardInterrupt

        def close(self):
            released.append(True)

    with pytest.raises(KeyboardInterrupt):
        record_plan(replace(written(tmp_path), backend=Interrupted), tmp_path / "out")
    assert released == [True]
    assert not (tmp_path / "out").exists()


def test_the_studys_motion_is_a_sine_about_home():
    robot = make_robot("fr3")
    motion = identification_motion(robot, Cell(16, 1), 0.1, 4)
    assert motion.name == "kp16_kd1"
    assert motion.q_des.shape == (200, len(robot.joints))
    np.testing.assert_array_equal(motion.q_des[0], robot.home)
    # a quarter of its period of 2 s
    np.testing.assert_allclose(motion.q_des[25], robot.home + 0.1)
    assert (motion.kp == 16).all()
    with VirtualRobot(robot) as arm:
        recording = arm.record(motion)
    assert recording.cell == "kp16_kd1"
    assert recording.notes == "the virtual fr3"
