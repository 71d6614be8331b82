"""The regressor of inverse dynamics against MuJoCo's inverse dynamics."""

import mujoco
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.sim.regressor import inertial_parameters, regressor

ARM = """<mujoco><worldbody><body name="base" pos="0 0 0.3">
  <body name="a" euler="20 0 10"><joint name="a" axis="0 0.6 0.8"/>
    <inertial pos="0.1 0.02 0" mass="1.2" diaginertia="0.01 0.02 0.025" quat="0.9 0.1 0.3 0"/>
    <body name="b" pos="0.3 0 0.1"><joint name="b" type="slide" axis="1 0 0"/>
      <inertial pos="0 0.1 0.05" mass="0.7" diaginertia="0.004 0.003 0.005"/>
      <body name="c" pos="0 0.2 0" euler="0 40 0"><joint name="c" axis="0 1 0"/>
        <inertial pos="0.05 0 0.1" mass="0.4" diaginertia="0.001 0.002 0.0015"/>
      </body></body></body></body></worldbody></mujoco>"""


def parameters(model):
    return inertial_parameters(
        model.body_mass, model.body_ipos, model.body_inertia, model.body_iquat
    )


@settings(max_examples=20)
@given(st.integers(0, 10_000))
def test_the_regressor_gives_the_inverse_dynamics_of_any_masses(seed):
    rng = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(ARM)
    data, dofs = mujoco.MjData(model), np.arange(3)

    def torque():
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse[dofs].copy()

    data.qpos[:], data.qvel[:], data.qacc[:] = rng.normal(size=(3, 3))
    before, at_first = torque(), parameters(model)
    y = regressor(model, data, dofs)
    assert np.allclose(np.einsum("bnk,bk->n", y, at_first), before, atol=1e-9)
    model.body_mass[2:] *= rng.uniform(0.5, 2, 3)
    model.body_ipos[2:] += rng.normal(size=(3, 3)) * 0.1
    model.body_inertia[2:] *= rng.uniform(0.8, 1.2, (3, 3))
    change = np.einsum("bnk,bk->n", y, parameters(model) - at_first)
    assert np.allclose(torque() - before, change, atol=1e-9)
