"""Every back end is watched while a command is held, by what it measures."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from t2l.cli.main import main
from t2l.hardware import Backend, Features, State
from t2l.hardware.backend import BeyondLimitError
from t2l.hardware.features import POSITION, TORQUE, VELOCITY
from t2l.hardware.motion import Motion
from t2l.hardware.virtual import VirtualRobot
from t2l.hardware.virtual_physics import known
from t2l.robots import make_robot

ROBOT = make_robot("fr3")
NJOINT = len(ROBOT.joints)
SLOWLY = {
    "backend": "virtual", "robot": "fr3", "gains": {"kp": 64, "kd": 4}, "command_rate_hz": 0.1,
    "excitation": {
        "kind": "triangle", "amplitude_rad": 0.1, "duration_s": 200, "frequency_hz": 0.01,
    },
}  # fmt: skip


class Scripted(Backend):
    """Shows at each tick of 10 ms what it is told to, and keeps what is asked of it."""

    name = "scripted"
    n = 1

    def __init__(self, real_time=False, signals=(POSITION, VELOCITY, TORQUE), **shown):
        self.robot, self.can = ROBOT, self.features(ROBOT, None)
        self.can = replace(self.can, real_time=real_time, signals=signals)
        self.shown, self.periods, self.held = shown, [], False

    @classmethod
    def features(cls, robot, settings):
        return Features(control_rate_hz=100)

    open = None

    def start(self, q, kp, kd):
        self.q = np.array(q)[None]
        return self.read()

    def send(self, q_des, period_s):
        assert not self.held
        self.periods.append(period_s)

    def read(self):
        state = {"q": self.q, "dq": np.zeros((1, NJOINT)), "tau": np.zeros((1, NJOINT))}
        state = {name: value.copy() for name, value in state.items()}
        # before the third command, within its tenth tick
        if len(self.periods) == 210:
            for name, (joint, value) in self.shown.items():
                state[name][0, joint] = value
        return State(**state)

    def hold(self):
        self.held = True

    def close(self):
        """Nothing to release."""


def held_still():
    """Four commands, each for a second."""
    ones = np.ones(NJOINT)
    return Motion("still", np.tile(ROBOT.home, (4, 1)), 1.0, 64 * ones, 4 * ones)


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        ({"q": (3, -3.1)}, r"position of fr3_joint4 -3.1 rad; allowed: -3.042 to -0.1518;"),
        ({"dq": (0, 2.7)}, r"velocity of fr3_joint1 2.7 rad/s; allowed: -2.62 to 2.62;"),
        ({"tau": (6, -12.5)}, r"torque of fr3_joint7 -12.5 N·m; allowed: -12 to 12;"),
        ({"dq": (2, np.nan)}, r"velocity of fr3_joint3 nan rad/s; allowed: -2.62 to 2.62;"),
    ],
    ids=str,
)
def test_a_joint_beyond_a_limit_between_two_commands_stops_the_robot(shown, said):
    arm = Scripted(**shown)
    with pytest.raises(BeyondLimitError, match=rf"still, 2\.10 s: .*stopped: found {said}"):
        arm.record(held_still())
    assert arm.held
    assert len(arm.periods) == 210


def test_what_is_not_measured_is_not_judged():
    arm = Scripted(signals=(POSITION, VELOCITY), tau=(0, np.nan))
    recording = arm.record(held_still())
    assert len(recording.q) == 4
    assert sum(arm.periods) == pytest.approx(4.0)


def test_a_robot_in_real_time_is_sent_a_command_as_often_as_a_policy_would():
    arm = Scripted(real_time=True)
    arm.can = replace(arm.can, control_rate_hz=1000)
    arm.record(held_still())
    np.testing.assert_allclose(arm.periods, 0.01)


def test_what_a_log_shows_between_two_looks_counts_too():
    class Logged(Scripted):
        def log_cycles(self, act, duration_s):
            from t2l.hardware.cycles import Cycles

            act()
            time = np.arange(400) / 100
            still = {name: np.zeros((400, NJOINT)) for name in ("dq", "tau")}
            still["dq"][123, 5] = 4.3
            q = np.tile(ROBOT.home, (400, 1))
            return Cycles(time, q, {"q": q, **still})

    arm = Logged()
    arm.can = replace(arm.can, logs_cycles=True)
    with pytest.raises(BeyondLimitError, match=r"still, 1.23 s: .* fr3_joint6 4.3 rad/s"):
        arm.record(held_still())
    assert arm.held


def test_looking_changes_no_recording():
    """What is measured within limits is what a robot measured that nobody looked at."""

    class Alone(VirtualRobot):
        def sending(self, q_des, period_s):
            self.send(q_des, period_s)
            yield self.read()

    n = np.arange(50)
    q_des = ROBOT.home + 0.05 * np.sin(2 * np.pi * n / 50)[:, None]
    motion = Motion("sine", q_des, 50.0, np.full(NJOINT, 64.0), np.full(NJOINT, 4.0))
    watched, alone = (arm(ROBOT).record(motion) for arm in (VirtualRobot, Alone))
    for signal in ("time", "q", "dq", "tau"):
        np.testing.assert_array_equal(getattr(watched, signal), getattr(alone, signal))


def test_a_machine_that_is_not_its_model_is_stopped_within_the_first_command(tmp_path, capsys):
    """Its motors are slow and nothing rubs, so that gains ring which the model is damped by."""
    physics = yaml.safe_load(known()["fr3"].read_text())
    for key, value in {"coulomb": 0.0, "viscous": 0.0, "torque_bandwidth_hz": 0.5}.items():
        physics[key]["value"] = value
    (tmp_path / "physics.yaml").write_text(yaml.safe_dump(physics))
    path, out = tmp_path / "plan.yaml", tmp_path / "out"
    path.write_text(yaml.safe_dump({**SLOWLY, "physics": str(tmp_path / "physics.yaml")}))
    main(["record", str(path), "--out", str(out), "--check"])
    assert "within all limits" in capsys.readouterr().out
    # a command is held for 10 s
    stopped = r"kp64_kd4, [1-4]\.\d\d s: the robot was stopped: found velocity of fr3_joint\d "
    with pytest.raises(SystemExit, match=stopped):
        main(["record", str(path), "--out", str(out)])
    assert not out.exists()
