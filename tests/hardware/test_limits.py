from pathlib import Path

import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.hardware.limits import (
    check_commands,
    check_state,
    fr3_limits,
    motion_torque,
    predicted_torque,
)
from t2l.robots import fr3

RATE = 50.0
TIME = np.arange(101) / RATE


@pytest.fixture(scope="module")
def limits():
    return fr3_limits()


def swing(amplitude, frequency_hz, joint):
    q_des = np.tile(np.array(fr3.HOME), (len(TIME), 1))
    q_des[:, joint] += amplitude * np.sin(2 * np.pi * frequency_hz * TIME)
    return q_des


def check(q_des, limits, kp=100.0):
    motion = motion_torque(q_des, RATE, limits)
    check_commands(q_des, RATE, np.full(7, kp), motion, limits, Path("plan.yaml"), "kp100_kd4")


def torque_of(q_des, kp, limits):
    return predicted_torque(q_des, np.full(7, kp), motion_torque(q_des, RATE, limits))


def test_a_gentle_motion_passes(limits):
    check(swing(0.2, 0.5, joint=3), limits)


@pytest.mark.parametrize(
    ("q_des", "kp", "message"),
    [
        (
            swing(0.9, 0.5, joint=3),
            100,
            r"plan.yaml: kp100_kd4: fr3_joint4 at \d\.\d\d s: found -3.0\d* rad; "
            r"allowed: -2.992 to -0.2018 rad, 0.05 rad within",
        ),
        (swing(0.4, 1.5, joint=1), 100, r"fr3_joint2 at 0.02 s: .* rad/s; .* up to 2.62 rad/s"),
        (swing(0.3, 2.0, joint=5), 800, r"fr3_joint6 .*found .* N·m, as the .* up to 12 N·m"),
        (swing(0.3, 1.3, joint=0), 3000, r"fr3_joint1 .*found .* N·m, as the .* up to 87 N·m"),
    ],
    ids=["position", "velocity", "wrist torque", "arm torque"],
)
def test_what_is_beyond_a_limit_is_named(limits, q_des, kp, message):
    with pytest.raises(RecordingError, match=message):
        check(q_des, limits, kp)


def test_resting_takes_no_torque_because_gravity_is_compensated(limits):
    torque = torque_of(swing(0.0, 1, joint=0), 100.0, limits)
    assert np.abs(torque).max() < 1e-6


def test_moving_takes_friction_inertia_and_the_step(limits):
    q_des = swing(0.1, 1.0, joint=6)
    soft, stiff = (torque_of(q_des, kp, limits) for kp in (0.0, 100.0))
    # the middle of a swing: friction of the MJCF, no acceleration
    assert soft[50, 6] == pytest.approx(0.248 + 0.21 * 0.2 * np.pi, rel=0.2)
    np.testing.assert_allclose(stiff[50, 6] - soft[50, 6], 100 * abs(q_des[50, 6] - q_des[49, 6]))


@pytest.mark.parametrize(
    ("q", "dq", "message"),
    [(-3.1, 0, r"at 1 s, fr3_joint4 measured: found -3.1 rad, so the arm"), (-2, 2.7, "2.7 rad/s")],
)
def test_a_moving_arm_is_watched(limits, q, dq, message):
    state, velocity = np.array(fr3.HOME), np.zeros(7)
    check_state(state, velocity, limits, Path("plan.yaml"), "at 1 s")
    state[3], velocity[3] = q, dq
    with pytest.raises(RecordingError, match=message):
        check_state(state, velocity, limits, Path("plan.yaml"), "at 1 s")
