import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from t2l.demos.retarget import hold
from t2l.sim.controllers import Arm
from t2l.sim.controllers.joint_pd import JointPD

ARM = """
<mujoco>
  <worldbody><body><joint name="a"/><geom size="0.1"/><site name="tip"/></body></worldbody>
  <actuator><position name="a" joint="a"/></actuator>
</mujoco>
"""


@pytest.fixture(scope="module")
def controller():
    model = mujoco.MjModel.from_xml_string(ARM)
    return JointPD(model, (Arm(("a",), "tip", np.zeros(1)),), 100.0, 10.0)


@given(
    commands=arrays(float, st.tuples(st.integers(1, 60), st.just(2)), elements=st.floats(-3, 3)),
    steps=st.integers(1, 20),
)
def test_the_mean_hold_keeps_the_impulse_of_every_complete_hold(controller, commands, steps):
    held = hold(commands, steps, "mean", controller)
    assert len(held) == -(-len(commands) // steps)
    for i, command in enumerate(held):
        np.testing.assert_allclose(command, commands[i * steps : (i + 1) * steps].mean(axis=0))


def test_the_sample_hold_takes_the_first_command(controller):
    commands = np.arange(7.0)[:, None]
    np.testing.assert_array_equal(hold(commands, 3, "sample", controller)[:, 0], [0, 3, 6])
    np.testing.assert_array_equal(hold(commands, 1, "mean", controller), commands)
