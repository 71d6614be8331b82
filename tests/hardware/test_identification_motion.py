import mujoco
import numpy as np
import pytest

from t2l.gains import Cell
from t2l.hardware.identification_motion import SAFE, identification_motion
from t2l.robots import make_robot, plant

ROBOT = make_robot("fr3")


def test_the_sine_is_the_studys():
    motion = identification_motion(ROBOT, Cell(16, 24), 0.15, 4)
    n = np.arange(200)
    expected = ROBOT.home + 0.15 * np.sin(np.pi * n / 50)[:, None]
    np.testing.assert_allclose(motion.q_des, expected, atol=1e-12)


def test_a_soft_joint_feels_three_times_what_breaks_it_loose():
    motion = identification_motion(ROBOT, Cell(16, 24), 0.15, 4, "multisine", 5.0, 1.5)
    offsets = motion.q_des - ROBOT.home
    # 16 N·m/rad times 0.28 rad
    np.testing.assert_allclose(16 * np.abs(offsets).max(axis=0), 4.5, rtol=1e-6)
    assert np.abs(offsets[[0, -1]]).max() < 1e-9
    spectrum = np.abs(np.fft.rfft(offsets, axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(offsets), 1 / motion.rate_hz)
    # but for its ramps, nothing above 5 Hz
    assert spectrum[frequency > 5.5].sum() < 0.01 * spectrum.sum()


@pytest.mark.parametrize("cell", [Cell(512, 2), Cell(512, 24)], ids=str)
def test_a_stiff_arm_keeps_its_limits_where_it_swings(cell):
    motion = identification_motion(ROBOT, cell, 0.15, 4, "multisine")
    model = plant.load(ROBOT.name, ROBOT.joints).compile()
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    data.qpos[:] = ROBOT.home
    mujoco.mj_forward(model, data)
    fastest = strongest = 0.0
    for k in range(4000):
        torque = cell.kp * (motion.q_des[k // 20] - data.qpos) - cell.kd * data.qvel
        data.qfrc_applied[:] = torque
        mujoco.mj_step(model, data)
        fastest = np.maximum(fastest, np.abs(data.qvel))
        strongest = np.maximum(strongest, np.abs(torque))
    assert np.all(fastest < 1.1 * SAFE * ROBOT.velocity_limit)
    assert np.all(strongest < 1.1 * SAFE * ROBOT.torque_limit)
    # and no smaller than they ask, in steps of a tenth
    used = np.maximum(fastest / ROBOT.velocity_limit, strongest / ROBOT.torque_limit) / SAFE
    assert used.max() > 0.8
