import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from t2l.sim.controllers.joint_pd import pd_torque, position_command

states = arrays(float, 5, elements=st.floats(-10, 10))
torques = arrays(float, 5, elements=st.floats(-87, 87))


@given(q=states, dq=states, torque=torques, kp=st.floats(1, 4096), kd=st.floats(0, 256))
def test_retargeting_is_the_exact_inverse_of_the_pd_law(q, dq, torque, kp, kd):
    q_des = position_command(q, dq, torque, kp, kd)
    scale = np.abs(torque).max() + kp * np.abs(q).max() + kd * np.abs(dq).max() + 1
    assert np.abs(pd_torque(q_des, q, dq, kp, kd) - torque).max() < 1e-13 * scale
