"""What other masses, gravity and encoders take, against MuJoCo's inverse dynamics."""

import copy

import mujoco
import numpy as np
import pytest

from t2l.sim.poses import Poses
from t2l.sim.regressor import inertial_parameters

ARM = """<mujoco><worldbody><body pos="0 0 1"><joint name="a" axis="0 0 1"/>
  <inertial pos="0 0 0.1" mass="2" diaginertia="0.02 0.02 0.01"/>
  <body pos="0 0 0.2"><joint name="b" axis="0 1 0"/>
    <inertial pos="0.2 0 0" mass="1.5" diaginertia="0.01 0.03 0.03"/>
    <body pos="0.4 0 0"><joint name="c" axis="0 1 0"/>
      <inertial pos="0.15 0.02 0" mass="0.8" diaginertia="0.004 0.01 0.01"/>
      <body pos="0.3 0 0"><joint name="d" type="slide" axis="0.6 0 0.8"/>
        <inertial pos="0 0 0.05" mass="0.3" diaginertia="1e-3 1e-3 1e-3"/>
</body></body></body></body></worldbody></mujoco>"""
JOINTS = np.arange(4)


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(ARM)


@pytest.fixture(scope="module")
def poses():
    t = np.arange(0, 0.2, 0.01)[:, None, None]
    rate = np.array([[[3.0, 5.0, 7.0, 4.0]]]) * np.array([[[1.0], [1.3]]])
    size = np.array([0.8, 0.6, 0.9, 0.1])
    q = 0.3 * size + size * np.sin(rate * t)
    return Poses(q, size * rate * np.cos(rate * t), -size * rate**2 * np.sin(rate * t), 0.01)


def exact(model, poses, offset=0.0, gravity=None, mass=1.0):
    """N·m (npose, nrec, n) beyond the model."""
    other, total = copy.copy(model), []
    if gravity is not None:
        other.opt.gravity[:] = gravity
    other.body_mass[2:] *= mass
    other.body_inertia[2:] *= mass
    for one, where in ((other, poses.q - offset), (model, poses.q)):
        data, out = mujoco.MjData(one), np.empty(poses.q.shape)
        for index in np.ndindex(out.shape[:2]):
            data.qpos[:], data.qvel[:] = where[index], poses.dq[index]
            data.qacc[:] = poses.ddq[index]
            mujoco.mj_inverse(one, data)
            out[index] = data.qfrc_inverse
        total.append(out)
    return total[0] - total[1]


def masses(model, factor):
    """Inertial parameters (1, nbody, 10) beyond the model's, where the last bodies are heavier."""
    own = inertial_parameters(
        model.body_mass, model.body_ipos, model.body_inertia, model.body_iquat
    )
    own[:2] = 0.0
    return (factor - 1) * own[None]


@pytest.mark.parametrize("changes", [{"gravity": True}, {"mass": True}, {"gravity": 1, "mass": 1}])
def test_other_masses_and_gravity_are_exact(model, poses, changes):
    gravity = np.array([2.0, -1.0, -9.0]) if "gravity" in changes else None
    factor = 1.3 if "mass" in changes else 1.0
    found = poses.beyond(
        model, JOINTS,
        masses(model, factor) if "mass" in changes else None,
        None if gravity is None else gravity[None],
    )[:, 0]  # fmt: skip
    expected = exact(model, poses, gravity=gravity, mass=factor)
    assert found == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("joint", range(4))
@pytest.mark.parametrize("rad", [0.02, 0.3])
def test_an_encoder_that_is_off_is_nearly_exact(model, poses, joint, rad):
    """Of one joint only velocities, which go with twice its angle, and no weight are not."""
    offset = rad * np.eye(4)[joint]
    found = poses.beyond(
        model, JOINTS, offset=np.broadcast_to(offset, (1, 2, 4)).copy()
    )[:, 0]  # fmt: skip
    expected = exact(model, poses, offset)
    assert np.abs(found - expected).max() <= max(rad**2, 1e-4) * np.abs(expected).max() + 1e-7


@pytest.mark.parametrize("changes", [{"gravity": True}, {"mass": True}])
def test_what_an_offset_does_beside_another_change_is_of_second_order(model, poses, changes):
    gravity = np.array([1.0, 1.0, -9.5]) if "gravity" in changes else None
    factor = 1.2 if "mass" in changes else 1.0
    left = []
    for rad in (0.02, 0.04):
        offset = rad * np.array([1.0, -1.0, 1.0, 0.5])
        found = poses.beyond(
            model, JOINTS,
            masses(model, factor) if "mass" in changes else None,
            None if gravity is None else gravity[None],
            np.broadcast_to(offset, (1, 2, 4)).copy(),
        )[:, 0]  # fmt: skip
        left.append(np.abs(found - exact(model, poses, offset, gravity, factor)).max())
    assert left[0] < 0.3 * left[1]
