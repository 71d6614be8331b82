"""Motions are simulated under their gains before anything moves."""

import mujoco
import numpy as np
import pytest
import yaml

from t2l.errors import RecordingError
from t2l.hardware.features import Features
from t2l.hardware.nominal import SampledLoop, respond
from t2l.hardware.plan import read_plan
from t2l.robots import make_robot
from t2l.robots.from_file import RobotFromFile
from tests.conftest import ROOT

ROBOT = make_robot("fr3")
INERTIA = 0.5
FREE = f"""<mujoco><option gravity="0 0 0"/><worldbody><body>
  <joint name="hinge" axis="0 0 1" range="-3 3" limited="true"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
</body></worldbody></mujoco>"""


def plan(folder, gains, amplitude_rad, frequency_hz, **changes):
    written = {
        "backend": "virtual", "robot": "fr3", "gains": gains,
        "excitation": {
            "kind": "sine", "amplitude_rad": amplitude_rad, "duration_s": 4,
            "frequency_hz": frequency_hz,
        },
    }  # fmt: skip
    path = folder / "plan.yaml"
    path.write_text(yaml.safe_dump(written | changes))
    return path


@pytest.mark.parametrize(
    ("gains", "amplitude_rad", "frequency_hz", "said"),
    [
        # a resonance that nothing damps
        (
            {"kp": 64, "kd": 1e-6}, 0.1, 2,
            r"kp64_kd0.000001: fr3_joint4 from \d\.\d\d s on: found up to \d+\.\d+ rad/s when "
            r"simulated under these gains; allowed: -2.62 to 2.62 rad/s; a slower or smaller",
        ),
        (
            {"kp": 16, "kd": 0.1}, 0.3, 0.6,
            r"kp16_kd0.1: fr3_joint\d from .* found up to -?\d\.\d+ rad/s when simulated",
        ),
        # more damping than a loop of 1000 Hz can give
        (
            {"kp": 64, "kd": 1e4}, 0.1, 2,
            r"kp64_kd10000: fr3_joint7: found kp 64 and kd 10000, under which the simulated joint "
            r"rings by itself at 500 Hz, ever more; allowed: kd between 0 and 148 N·m·s/rad",
        ),
    ],
    ids=["hardly damped", "soft", "damped too much"],
)  # fmt: skip
def test_gains_that_no_limit_of_a_command_finds_are_refused(
    tmp_path, gains, amplitude_rad, frequency_hz, said
):
    with pytest.raises(RecordingError, match=said):
        read_plan(plan(tmp_path, gains, amplitude_rad, frequency_hz))


def test_a_command_that_is_held_for_long_is_a_step(tmp_path):
    """Between commands 10 s apart lies no velocity, but the joint still jumps."""
    hold = {"kind": "hold", "duration_s": 100, "ramp_s": 10}
    hold["amplitude_rad"] = [0, 0, 0, 0, 0, 0, 1.2]
    path = plan(tmp_path, {"kp": 9, "kd": 0.01}, 0, 0, excitation=hold, command_rate_hz=0.1)
    with pytest.raises(RecordingError, match=r"fr3_joint7 from 1\d\.\d\d s on: .* rad/s when"):
        read_plan(path)


def test_the_gains_of_the_study_are_not_refused(tmp_path):
    """With its own motion, in every corner of its grid."""
    gains = [{"kp": kp, "kd": kd} for kp in (16, 128, 512) for kd in (1, 24)]
    assert len(read_plan(plan(tmp_path, gains, 0.15, 0.5)).motions) == 6
    read_plan(ROOT / "examples/record_fr3.yaml")


def free_joint(folder):
    path = folder / "free.xml"
    path.write_text(FREE)
    return RobotFromFile(path, np.array([9.0]), np.array([1e6]))


@pytest.mark.parametrize("rate", [100, 1000])
def test_a_joint_alone_rings_where_jurys_criterion_says(tmp_path, rate):
    loop = SampledLoop(free_joint(tmp_path), Features(rate), np.zeros(1))
    kp = 20.0
    low, high = kp / rate / 2, 2 * INERTIA * rate

    def ringing(kd):
        return loop.ringing(np.array([kp]), np.array([kd]))

    assert ringing(1.01 * low) is None
    assert ringing(0.99 * high) is None
    swing, chatter = ringing(0.99 * low), ringing(1.01 * high)
    assert swing.frequency_hz == pytest.approx(np.sqrt(kp / INERTIA) / 2 / np.pi, rel=0.02)
    assert chatter.frequency_hz == pytest.approx(rate / 2, rel=0.02)
    assert f"kd between {low:.3g} and {high:.3g}" in swing.allowed
    assert loop.ringing(np.array([1e300]), np.array([1.0])) is not None


def test_what_the_linear_loop_says_the_simulation_does(tmp_path):
    robot, features = free_joint(tmp_path), Features(100)
    q_des = np.r_[0.0, np.full(400, 0.01)][None, :, None]
    spread = {}
    for part in (0.9, 1.1):
        kd = np.array([part * 20 / 100 / 2])
        q = respond(robot, features, q_des, 50.0, np.array([20.0]), kd).q[0, :, 0]
        spread[part] = [np.ptp(half) for half in np.array_split(q[1:], 2)]
    assert spread[0.9][1] > spread[0.9][0]
    assert spread[1.1][1] < spread[1.1][0]


def test_a_response_is_what_mujoco_makes_of_the_same_torques():
    motion = ROBOT.home + 0.1 * np.sin(np.pi * np.arange(100) / 50)[:, None]
    kp, kd = np.full(7, 256.0), np.full(7, 12.0)
    found = respond(ROBOT, Features(1000), motion[None], 50.0, kp, kd)
    from t2l.robots import plant

    model = plant.load(ROBOT.name, ROBOT.joints).compile()
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    data.qpos[:] = ROBOT.home
    mujoco.mj_forward(model, data)
    for k in range(2000):
        if k % 5 == 0:
            np.testing.assert_allclose(found.q[0, k // 5], data.qpos, atol=2e-3)
        data.qfrc_applied[:] = kp * (motion[k // 20] - data.qpos) - kd * data.qvel
        mujoco.mj_step(model, data)
    assert found.q_des.shape == found.torque.shape == (1, 400, 7)
    np.testing.assert_allclose(
        found.torque, kp * (found.q_des - found.q) - kd * found.dq, atol=1e-9
    )
