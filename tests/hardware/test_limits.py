from pathlib import Path

import numpy as np
import pytest

from t2l.errors import RecordingError
from t2l.hardware.limits import (
    Bounds,
    check_motion,
    motion_torque,
    predicted_torque,
    state_objections,
)
from t2l.hardware.motion import Motion
from t2l.robots import make_robot

ROBOT = make_robot("fr3_hand")
RATE = 50.0
TIME = np.arange(101) / RATE


def swing(amplitude, frequency_hz, joint, kp=100.0):
    q_des = np.tile(ROBOT.home, (len(TIME), 1))
    q_des[:, joint] += amplitude * np.sin(2 * np.pi * frequency_hz * TIME)
    gains = np.full(len(ROBOT.joints), kp)
    return Motion("kp100_kd4", q_des, RATE, gains, gains / 25)


def check(motion):
    torque = motion_torque(ROBOT, motion.q_des, RATE)
    check_motion(ROBOT, motion, torque, Path("plan.yaml"))


def test_a_gentle_motion_passes():
    check(swing(0.2, 0.5, joint=3))


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (
            swing(0.9, 0.5, joint=3),
            r"plan.yaml: kp100_kd4: fr3_joint4 at \d\.\d\d s: found -3.0\d* rad; "
            r"allowed: -2.992 to -0.2018 rad, 0.05 rad within",
        ),
        (swing(0.4, 1.5, joint=1), r"fr3_joint2 at 0.02 s: .* rad/s; .* -2.62 to 2.62 rad/s"),
        (swing(0.3, 2.0, 5, kp=800), r"fr3_joint6 .*found .* N·m, as the .* to 12 N·m"),
        (swing(0.3, 1.3, 0, kp=3000), r"fr3_joint1 .*found .* N·m, as the .* to 87 N·m"),
    ],
    ids=["position", "velocity", "wrist torque", "arm torque"],
)
def test_what_is_beyond_a_limit_is_named(motion, message):
    with pytest.raises(RecordingError, match=message):
        check(motion)


def test_resting_takes_no_torque_because_gravity_is_compensated():
    motion = swing(0.0, 1, joint=0)
    torque = predicted_torque(motion, motion_torque(ROBOT, motion.q_des, RATE))
    assert np.abs(torque).max() < 1e-6


def test_moving_takes_friction_inertia_and_the_step():
    soft, stiff = (swing(0.1, 1.0, joint=6, kp=kp) for kp in (1e-9, 100.0))
    torque = motion_torque(ROBOT, soft.q_des, RATE)
    soft, stiff, q_des = predicted_torque(soft, torque), predicted_torque(stiff, torque), soft.q_des
    # the middle of a swing: friction of the MJCF, no acceleration
    assert soft[50, 6] == pytest.approx(0.248 + 0.21 * 0.2 * np.pi, rel=0.2)
    np.testing.assert_allclose(stiff[50, 6] - soft[50, 6], 100 * abs(q_des[50, 6] - q_des[49, 6]))


def test_of_several_robots_each_has_its_own_objection():
    q = np.tile(ROBOT.home, (4, 1))
    dq = np.zeros_like(q)
    q[1, 3], dq[2, 0], q[3, 6] = -3.1, 2.7, np.nan
    fine, far, fast, unknown = state_objections(ROBOT, q, dq)
    assert fine == ""
    assert far == "position of fr3_joint4 -3.1 rad; allowed: -3.042 to -0.1518"
    assert fast == "velocity of fr3_joint1 2.7 rad/s; allowed: -2.62 to 2.62"
    assert "fr3_joint7 nan rad" in unknown


def test_where_there_is_no_limit_nothing_is_outside():
    free = Bounds(["a"], np.array([-np.inf]), np.array([np.inf]), "rad")
    assert not free.outside(np.array([[1e9], [-1e9]])).any()
