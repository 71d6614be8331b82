import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from t2l.errors import ConfigurationError
from t2l.rl.interface import command, per_joint, steps_held
from t2l.tasks.reach import CENTRE, joint_ranges

ACTIONS = arrays(float, (3, 7), elements=st.floats(-1, 1))


@given(ACTIONS, st.floats(0.001, 5), st.floats(0.001, 5))
def test_commands_never_leave_the_joints_ranges(action, proximal, distal):
    low, high = joint_ranges().T
    scale = per_joint((proximal, distal))
    q_des = command(np.tile(CENTRE, (3, 1)), action, scale, joint_ranges())
    assert ((q_des >= low) & (q_des <= high)).all()
    within = (CENTRE + scale * action >= low) & (CENTRE + scale * action <= high)
    np.testing.assert_array_equal(q_des[within], (CENTRE + scale * action)[within])


def test_what_is_no_number_stays_so():
    action = np.zeros((1, 7))
    action[0, 2] = np.nan
    q_des = command(np.array([CENTRE]), action, per_joint((1.0, 1.0)), joint_ranges())
    assert np.isnan(q_des).tolist() == [[False, False, True, False, False, False, False]]


def test_an_action_is_held_for_whole_steps():
    assert steps_held(100.0, 50.0, "the simulator's") == 2
    with pytest.raises(ConfigurationError, match="policy rate: found 30 Hz"):
        steps_held(100.0, 30.0, "the simulator's")
