"""Inverse dynamics at many places, and their regressor, against MuJoCo's inverse dynamics."""

import mujoco
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.sim.regressor import inertial_parameters, inverse_dynamics, regressor

ARM = """<mujoco><option gravity="1 -2 -9"/><worldbody><body name="base" pos="0 0 0.3">
  <body name="a" euler="20 0 10"><joint name="a" axis="0 0.6 0.8" pos="0.1 0 0.05"/>
    <inertial pos="0.1 0.02 0" mass="1.2" diaginertia="0.01 0.02 0.025" quat="0.9 0.1 0.3 0"/>
    <body name="b" pos="0.3 0 0.1"><joint name="b" type="slide" axis="1 0 0" ref="0.2"/>
      <inertial pos="0 0.1 0.05" mass="0.7" diaginertia="0.004 0.003 0.005"/>
      <body name="still" pos="0.1 0 0" euler="0 0 30"><joint name="still" axis="1 0 0"/>
        <inertial pos="0 0.1 0.05" mass="0.3" diaginertia="0.004 0.003 0.005"/></body>
      <body name="c" pos="0 0.2 0" euler="0 40 0"><joint name="c" axis="0 1 0"/>
        <joint name="d" axis="1 0 0" pos="0 0.1 0"/>
        <inertial pos="0.05 0 0.1" mass="0.4" diaginertia="0.001 0.002 0.0015"/>
      </body></body></body></body></worldbody></mujoco>"""
MOVING = ("c", "a", "b", "d")
PLACES = 5


def parameters(model):
    return inertial_parameters(
        model.body_mass, model.body_ipos, model.body_inertia, model.body_iquat
    )


@settings(max_examples=20)
@given(st.integers(0, 10_000))
def test_inverse_dynamics_of_any_masses_are_those_of_mujoco(seed):
    rng = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(ARM)
    data, dofs = mujoco.MjData(model), [model.joint(name).dofadr[0] for name in MOVING]
    motion = rng.normal(size=(3, len(dofs), PLACES))

    def torque():
        out = np.empty(motion.shape[1:])
        for i in range(PLACES):
            data.qpos[dofs], data.qvel[dofs], data.qacc[dofs] = motion[:, :, i]
            mujoco.mj_inverse(model, data)
            out[:, i] = data.qfrc_inverse[dofs]
        return out

    before, at_first = torque(), parameters(model)
    gravity = model.opt.gravity
    assert np.allclose(inverse_dynamics(model, dofs, motion, gravity), before, atol=1e-9)
    y = regressor(model, dofs, motion, gravity)
    assert np.allclose(np.einsum("bnkp,bk->np", y, at_first), before, atol=1e-9)
    moved = slice(2, None)
    model.body_mass[moved] *= rng.uniform(0.5, 2, model.nbody - 2)
    model.body_ipos[moved] += rng.normal(size=(model.nbody - 2, 3)) * 0.1
    model.body_inertia[moved] *= rng.uniform(0.8, 1.2, (model.nbody - 2, 3))
    change = np.einsum("bnkp,bk->np", y, parameters(model) - at_first)
    assert np.allclose(torque() - before, change, atol=1e-9)
