import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from t2l.demos.retarget import hold, position_command
from t2l.sim.controllers.joint_pd import pd_torque

states = arrays(float, 7, elements=st.floats(-10, 10))
torques = arrays(float, 7, elements=st.floats(-87, 87))


@given(q=states, dq=states, torque=torques, kp=st.floats(1, 4096), kd=st.floats(0, 256))
def test_retargeting_is_the_exact_inverse_of_the_pd_law(q, dq, torque, kp, kd):
    q_des = position_command(q, dq, torque, kp, kd)
    scale = np.abs(torque).max() + kp * np.abs(q).max() + kd * np.abs(dq).max() + 1
    assert np.abs(pd_torque(q_des, q, dq, kp, kd) - torque).max() < 1e-13 * scale


@given(
    commands=arrays(float, st.tuples(st.integers(1, 60), st.just(2)), elements=st.floats(-3, 3)),
    steps=st.integers(1, 20),
)
def test_the_mean_hold_keeps_the_impulse_of_every_complete_hold(commands, steps):
    held = hold(commands, steps, "mean")
    assert len(held) == -(-len(commands) // steps)
    for i, command in enumerate(held):
        np.testing.assert_allclose(command, commands[i * steps : (i + 1) * steps].mean(axis=0))


def test_the_sample_hold_takes_the_first_command():
    commands = np.arange(7.0)[:, None]
    np.testing.assert_array_equal(hold(commands, 3, "sample")[:, 0], [0, 3, 6])
    np.testing.assert_array_equal(hold(commands, 1, "mean"), commands)
