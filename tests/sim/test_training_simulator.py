import numpy as np
import pytest

from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from t2l.sim.training_simulator import Simulator

ROBOT = make_robot("fr3")
HOME = ROBOT.home


def made(n=1):
    return Simulator(position_controlled(ROBOT), ROBOT.joints, ROBOT.torque_limit, n, 100)


def parameters(**changes):
    return {
        "stiffness": 100.0, "damping": 10.0, "armature": 0.1, "static_friction": 0.01,
        "dynamic_friction_ratio": 1.0, "viscous_friction": 0.0,
    } | changes  # fmt: skip


def simulate(change, n=1, seconds=2.0, **rest):
    simulator = made(n)
    simulator.set_parameters(parameters(**rest))
    q_des = np.tile(HOME + change, (int(50 * seconds), 1))
    return simulator.simulate(q_des, HOME, 0.0, nstep=2)


@pytest.mark.parametrize("kp", [16.0, 512.0])
@pytest.mark.parametrize("kd", [1.0, 24.0])
def test_every_corner_is_stable_at_100_hz(kp, kd):
    q, dq = simulate(0.05, seconds=8.0, stiffness=kp, damping=kd)
    assert np.isfinite(q).all()
    # with Kp 16 and Kd 24 the slowest joint creeps with a time constant of 1.5 s
    np.testing.assert_allclose(q[0, -1], HOME + 0.05, atol=5e-3)
    assert np.abs(dq[0, -1]).max() < 0.02


def test_static_friction_holds_what_dynamic_friction_lets_slide():
    # 16 N·m/rad times 0.05 rad is 0.8 N·m, below static friction
    held, _ = simulate(0.05, stiffness=16.0, static_friction=1.0, dynamic_friction_ratio=0.2)
    assert np.abs(held - HOME).max() < 1e-4
    # once 1.6 N·m have broken it loose, only 0.2 N·m brake it
    slid, _ = simulate(0.1, stiffness=16.0, static_friction=1.0, dynamic_friction_ratio=0.2)
    rubbed, _ = simulate(0.1, stiffness=16.0, static_friction=1.0, dynamic_friction_ratio=1.0)
    end = HOME + 0.1
    assert np.all(np.abs(slid[0, -1] - end) < np.abs(rubbed[0, -1] - end))


def test_simulations_of_a_batch_do_not_touch_each_other():
    alone, _ = simulate(0.1, stiffness=64.0)
    # neither saturates: where one does, the commands of all are written anew, rounded
    both, _ = simulate(0.1, n=2, stiffness=np.array([[64.0], [100.0]]))
    np.testing.assert_array_equal(both[0], alone[0])
    assert np.abs(both[1] - both[0]).max() > 1e-3


def test_a_light_damped_joint_that_saturates_is_slowed_by_its_damping():
    # the last joint as once identified: a torque held for 10 ms would make it 5 rad/s fast
    simulator = made()
    simulator.set_parameters(parameters(stiffness=895.0, damping=37.0, armature=0.015))
    simulator.q[:] = HOME
    for sign in (1, -1) * 5:
        q_des = simulator.q.copy()
        q_des[0, -1] += 0.02 * sign  # asks for 18 N·m of 12
        for _ in range(2):
            simulator.step(q_des, 1)
            # about 12 N·m against 37 N·m·s/rad
            assert abs(simulator.dq[0, -1]) < 0.5
