import mujoco
import numpy as np
import pytest

from t2l.sim import apply_position_gains, apply_torque_control, diverged, make_batch, step


def test_gains_in_a_batch_match_a_model_with_those_gains(task):
    kp, kd = np.array([[16.0], [512.0], [2048.0]]), np.array([[24.0], [2.0], [128.0]])
    starts = task.sample_starts(np.random.default_rng(0), 3)
    q_des = starts[:, task.arm_qpos] + 0.1
    batch = make_batch(task.model, 3, threads=2)
    apply_position_gains(batch, task.robot.joints, kp, kd)
    task.reset(batch, starts)
    task.command(batch.ctrl, q_des, 0.04)
    batch.step(nstep=200)

    for i in range(3):
        spec = task.spec(visual=False)
        for joint in task.robot.joints:
            spec.actuator(joint).set_to_position(kp=kp[i, 0], kv=kd[i, 0])
        model = spec.compile()
        data = mujoco.MjData(model)
        data.qpos[:] = starts[i]
        task.command(data.ctrl, q_des[i], 0.04)
        for _ in range(200):
            mujoco.mj_step(model, data)
        np.testing.assert_array_equal(batch.qpos[i], data.qpos)


def test_the_actuator_is_the_pd_law_at_the_end_of_the_step(task):
    batch = make_batch(task.model, 1)
    starts = task.sample_starts(np.random.default_rng(1), 1)
    arm = task.arm_qpos
    q_des = starts[:, arm] + 0.02
    apply_position_gains(batch, task.robot.joints, 300.0, 20.0)
    task.reset(batch, starts)
    task.command(batch.ctrl, q_des, 0.04)
    batch.step()
    torque = 300.0 * (q_des - batch.qpos[:, arm]) - 20.0 * batch.qvel[:, arm]

    motors = make_batch(task.model, 1)
    apply_torque_control(motors, task.robot.joints)
    task.reset(motors, starts)
    task.command(motors.ctrl, torque, 0.04)
    motors.step()
    np.testing.assert_allclose(motors.qpos, batch.qpos, atol=1e-12)


def test_torques_stop_at_the_data_sheet(task):
    limit = np.array(task.robot.torque_limit)
    np.testing.assert_array_equal(limit, [87, 87, 87, 87, 12, 12, 12])
    batch = make_batch(task.model, 1)
    apply_position_gains(batch, task.robot.joints, 1e5, 1.0)
    starts = task.sample_starts(np.random.default_rng(0), 1)
    task.reset(batch, starts)
    task.command(batch.ctrl, starts[:, task.arm_qpos] + 1.0, 0.04)
    force = batch.bind("qfrc_actuator")
    batch.step()
    np.testing.assert_allclose(force[0, task.arm_qpos], limit)


def test_the_stiffest_and_most_damped_cell_is_stable(task):
    batch = make_batch(task.model, 1)
    apply_position_gains(batch, task.robot.joints, 2048.0, 128.0)
    starts = task.sample_starts(np.random.default_rng(0), 1)
    task.reset(batch, starts)
    q_des = starts[:, task.arm_qpos] + 0.02
    task.command(batch.ctrl, q_des, 0.04)
    batch.step(nstep=1500)
    np.testing.assert_allclose(batch.qpos[:, task.arm_qpos], q_des, atol=2e-3)
    assert np.abs(batch.qvel).max() < 1e-3


@pytest.mark.parametrize("poison", [np.nan, 1e12])
def test_a_diverging_simulation_is_taken_out_and_the_others_go_on(
    task, poison, capfd, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    starts = task.sample_starts(np.random.default_rng(0), 3)
    batch = make_batch(task.model, 3)
    apply_position_gains(batch, task.robot.joints, 100.0, 10.0)
    task.reset(batch, starts)
    batch.qvel[1, 0] = poison
    running = np.ones(3, dtype=bool)
    for _ in range(3):
        step(batch, running, nstep=10)
    np.testing.assert_array_equal(running, [True, False, True])
    task.reset(batch, starts)
    assert not diverged(batch).any()
    # MuJoCo would print every warning and write it to a file where the user works
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())
