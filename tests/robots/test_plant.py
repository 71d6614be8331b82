import mujoco
import numpy as np
import pytest
from benchmarks.hidden_effects.cases import ROBOTS

from t2l.errors import ConfigurationError
from t2l.robots import make_robot, plant
from t2l.sim.servo import torque_limits

# an arm with what a manufacturer's MJCF may have: a gripper, sensors, keys, looks
ROBOT = """<mujoco><compiler angle="radian"/>
<default><joint armature="0.01" damping="0.1"/></default>
<worldbody>
  <geom name="floor" type="plane" size="1 1 0.1"/>
  <body name="cube" pos="1 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>
  <body name="upper" pos="0 0 1">
    <joint name="shoulder" axis="0 1 0" range="-2 2" limited="true"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3" mass="0.6"/>
    <body name="lower" pos="0 0 -0.3">
      <joint name="elbow" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="0.4" diaginertia="1e-3 1e-3 1e-3"/>
      <geom name="shell" type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3"/>
      <body name="left" pos="0.01 0 -0.3"><joint name="finger_left" type="slide" axis="1 0 0"
        range="0 0.04"/><geom type="box" size="0.01 0.01 0.02" mass="0.05"/></body>
      <body name="right" pos="-0.01 0 -0.3"><joint name="finger_right" type="slide" axis="-1 0 0"
        range="0 0.04"/><geom type="box" size="0.01 0.01 0.02" mass="0.05"/></body>
      <body name="ball" pos="0 0 -0.4"><joint name="swivel" type="ball"/>
        <geom size="0.01" mass="0.01"/></body>
    </body>
  </body>
</worldbody>
<contact><exclude body1="upper" body2="lower"/></contact>
<equality><joint joint1="finger_left" joint2="finger_right"/></equality>
<actuator>
  <position name="shoulder" joint="shoulder" kp="100" forcerange="-8 8" gear="2"/>
  <motor name="elbow" joint="elbow"/>
  <motor name="grip" joint="finger_left"/>
</actuator>
<sensor><jointpos joint="finger_left"/></sensor>
<keyframe><key name="home" qpos="0 0 0 1 0 0 0 0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>"""


TENDON = """<tendon><fixed name="grip"><joint joint="finger_left" coef="0.5"/>
  <joint joint="finger_right" coef="0.5"/></fixed></tendon>
<actuator><general name="both" tendon="grip" forcerange="-100 100"/></actuator></mujoco>"""


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(ROBOT)
    return str(path)


def subtree_mass(model, body="upper"):
    return model.body(body).subtreemass[0]


def test_only_the_joints_asked_for_move(robot):
    model = plant.load(robot, ["shoulder", "elbow"]).compile()
    assert [model.joint(i).name for i in range(model.njnt)] == ["shoulder", "elbow"]
    assert model.nu == model.neq == model.nsensor == model.nkey == model.nexclude == 0
    data = mujoco.MjData(model)
    data.qpos[:] = 1.0, -2.9  # the forearm through the upper arm
    mujoco.mj_forward(model, data)
    assert data.ncon == 0


def test_the_body_weighs_and_swings_as_in_its_file(robot):
    """Held joints carry their bodies; what gives mass stays when looks go."""
    whole = mujoco.MjModel.from_xml_path(robot)
    model = plant.load(robot, ["shoulder"]).compile()
    assert subtree_mass(model) == pytest.approx(subtree_mass(whole))
    bias = []
    for each in (whole, model):
        data = mujoco.MjData(each)
        data.qpos[each.joint("shoulder").qposadr[0]] = 0.7
        mujoco.mj_forward(each, data)
        bias.append(data.qfrc_bias[each.joint("shoulder").dofadr[0]])
    assert bias[1] == pytest.approx(bias[0], rel=1e-9)


def test_a_tendon_between_held_joints_goes_with_them(tmp_path):
    """As of the gripper in the usual MJCF of the Franka Panda."""
    path = tmp_path / "panda.xml"
    path.write_text(ROBOT.replace("</mujoco>", TENDON))
    assert plant.load(str(path), ["shoulder", "elbow"]).compile().nv == 2


def test_inertia_that_the_compiler_takes_from_geoms_stays(robot):
    path = robot.replace("robot.xml", "from_geoms.xml")
    with open(path, "w") as file:
        file.write(ROBOT.replace("<compiler ", '<compiler inertiafromgeom="true" '))
    whole = mujoco.MjModel.from_xml_path(path)
    model = plant.load(path, ["shoulder", "elbow"]).compile()
    assert subtree_mass(model) == pytest.approx(subtree_mass(whole))


def test_limits_of_actuators_become_limits_of_joints(robot):
    model = plant.load(robot, ["shoulder", "elbow"]).compile()
    np.testing.assert_array_equal(
        torque_limits(model, ("elbow", "shoulder")), [[-np.inf, np.inf], [-16.0, 16.0]]
    )
    np.testing.assert_array_equal(
        plant.position_ranges(model, ("elbow", "shoulder")), [[-np.inf, np.inf], [-2.0, 2.0]]
    )


def test_a_robot_is_known_by_name():
    robot = make_robot("fr3")
    model = plant.load("fr3", robot.joints).compile()
    assert [model.joint(i).name for i in range(model.njnt)] == list(robot.joints)
    np.testing.assert_allclose(torque_limits(model, robot.joints)[:, 1], robot.torque_limit)
    assert model.nmesh == 0


def test_files_below_the_mjcf_are_found():
    robot = ROBOTS["two_joint_arm"]
    assert plant.load(str(robot.mjcf), robot.joints).compile().nv == 2


@pytest.mark.parametrize("joint", ["wrist", "swivel", ""])
def test_a_joint_that_cannot_be_driven_is_named(robot, joint):
    with pytest.raises(ConfigurationError) as caught:
        plant.load(robot, ["shoulder", joint])
    message = str(caught.value)
    assert robot in message
    assert repr(joint) in message
    assert "shoulder, elbow, finger_left, finger_right" in message


def test_a_missing_robot_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r"robot: .*panda\.xml.*fr3"):
        plant.load(str(tmp_path / "panda.xml"), ["a"])


@pytest.mark.parametrize("text", ["<mujoco><worldbody>", "a,b", "", "\0\1"])
def test_a_file_that_is_not_mjcf_is_named(tmp_path, text):
    path = tmp_path / "odd.xml"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=r"odd\.xml: MuJoCo cannot read it"):
        plant.load(str(path), ["a"])
