import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from t2l.sim.rotations import rotation_vectors


@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: np.linalg.norm(axis) > 1e-3),
    angle=st.floats(0, np.pi) | st.floats(0, 1e-6) | st.floats(np.pi - 1e-6, np.pi),
)
def test_they_are_scipys(axis, angle):
    turn = Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis))
    found = rotation_vectors(turn.as_matrix()[None])[0]
    # at half a turn either way round is the same rotation
    assert (Rotation.from_rotvec(found) * turn.inv()).magnitude() < 1e-14
    assert np.linalg.norm(found) == pytest.approx(turn.magnitude(), abs=1e-14)


def test_no_turn_half_a_turn_and_what_is_no_number():
    matrices = [np.eye(3), np.diag([1, -1, -1]), np.diag([-1, -1, 1]), np.full((3, 3), np.nan)]
    found = rotation_vectors(np.array(matrices, float))
    assert found[0].tolist() == [0, 0, 0]
    np.testing.assert_allclose(abs(found[1:3]), [[np.pi, 0, 0], [0, 0, np.pi]])
    assert np.isnan(found[3]).all()
