import mujoco
import numpy as np
import pytest

from t2l.sim.batch import make_batch
from t2l.sim.gravity import GravityCompensation

MACHINE = """<mujoco><worldbody>
 <body gravcomp="1"><joint name="lift" type="slide" axis="0.2 0 1"/>
  <inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>
  <body pos="0.1 0 0.2" gravcomp="1"><joint name="turn" axis="0 1 0.3" pos="0 0.1 0"/>
   <inertial pos="0.2 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
   <body pos="0.3 0.1 0" gravcomp="0.5"><joint name="bend" axis="1 1 0"/>
    <inertial pos="0.1 0.2 0" mass="0.7" diaginertia="0.1 0.1 0.1"/>
    <body pos="0 0 0.1"><inertial pos="0 0 0.1" mass="3" diaginertia="0.1 0.1 0.1"/></body>
 </body></body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("joints", [("lift", "turn", "bend"), ("bend", "lift")])
def test_it_is_the_gravity_torque_of_the_bodies_that_are_compensated(joints):
    model = mujoco.MjModel.from_xml_string(MACHINE)
    batch = make_batch(model, 5)
    compensation, expected = GravityCompensation(batch, joints), batch.bind("qfrc_gravcomp")
    batch.qpos[:] = np.random.default_rng(0).uniform(-1, 1, (5, 3))
    batch.forward()
    dofs = [model.joint(name).dofadr[0] for name in joints]
    np.testing.assert_allclose(compensation(0.0), expected[:, dofs], atol=1e-12)


def test_between_places_of_masses_it_goes_on_as_it_changed():
    model = mujoco.MjModel.from_xml_string(MACHINE)
    batch = make_batch(model, 1)
    compensation = GravityCompensation(batch, ("turn",))
    found = []
    for angle in (0.30, 0.31, 0.315):
        batch.qpos[:, 1] = angle
        batch.forward()
        found.append(compensation(0.5)[0, 0])
    assert found[1] == pytest.approx(compensation.last[0, 0], rel=1e-4)
