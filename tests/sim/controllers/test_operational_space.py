import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from t2l.sim.controllers.operational_space import (
    operational_space_torque,
    rotation_error,
)


@given(seed=st.integers(0, 10_000))
def test_the_grip_accelerates_as_asked_and_the_posture_does_not_disturb_it(seed):
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(7, 7))
    mass = (factor @ factor.T + 3 * np.eye(7))[None]
    jacobian = rng.normal(size=(1, 6, 7))
    q, dq, bias = rng.normal(size=(3, 1, 7))
    error, twist_des, acceleration_des = rng.normal(size=(3, 1, 6))
    torque = operational_space_torque(
        *(q, dq, mass, jacobian, bias, error),
        *(twist_des, acceleration_des, rng.normal(size=7), 100.0, 20.0),
    )
    acceleration = jacobian[0] @ np.linalg.solve(mass[0], (torque - bias)[0])
    asked = acceleration_des + 100 * error + 20 * (twist_des - (jacobian @ dq[0])[..., :])
    condition = np.linalg.cond(jacobian[0] @ np.linalg.solve(mass[0], jacobian[0].T))
    # damped least squares gives up accuracy near singular poses
    if condition < 100:
        np.testing.assert_allclose(acceleration, asked[0], rtol=0.05, atol=0.05 * abs(asked).max())


def test_rotation_error_is_the_small_turn_between_two_frames():
    turn = np.array([0.01, -0.02, 0.015])
    frame = Rotation.from_rotvec([0.3, 1.0, -0.4])
    turned = Rotation.from_rotvec(turn) * frame
    error = rotation_error(turned.as_matrix()[None], frame.as_matrix()[None])[0]
    np.testing.assert_allclose(error, turn, rtol=1e-3)
