import os

import mujoco
import numpy as np
import pytest
from benchmarks.hidden_effects.cases import ROBOTS

from t2l.errors import ConfigurationError
from t2l.robots import make_robot, plant
from t2l.sim.loop import torque_limits

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


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco><worldbody>", "no XML that can be read"),
        ("a,b", "no XML that can be read"),
        ("", "no XML that can be read"),
        ("\0\1", "no XML that can be read"),
        ("<mujoco><worldbodi/></mujoco>", "MuJoCo cannot read it"),
    ],
)
def test_a_file_that_is_not_mjcf_is_named(tmp_path, text, said):
    path = tmp_path / "odd.xml"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=rf"odd\.xml: .*{said}"):
        plant.load(str(path), ["a"])


URDF = """<robot name="arm">
  <link name="base"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.8"/><axis xyz="0 1 0"/>
    <limit lower="-2.6" upper="2.6" effort="30" velocity="4"/>
    <dynamics damping="0.05" friction="0.1"/>
  </joint>
  <link name="upper">
    <inertial><origin xyz="0 0 -0.15"/><mass value="0.6"/>
      <inertia ixx="4e-3" iyy="4e-3" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://arm/upper.stl"/></geometry></visual>
    <collision><geometry><mesh filename="package://arm/upper_c.stl"/></geometry></collision>
  </link>
</robot>"""
TWO_JOINTS = URDF.replace(
    "</robot>",
    """<joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1.5" effort="3" velocity="4"/><mimic_/></joint>
  <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="0.3"/>
    <inertia ixx="1.1e-3" iyy="1.2e-3" izz="2e-4" ixy="1e-5" ixz="2e-5" iyz="3e-5"/></inertial>
  </link></robot>""",
)
MJCF_OF_IT = """<mujoco><compiler angle="radian"/><worldbody><body name="upper" pos="0 0 0.8">
  <joint name="shoulder" axis="0 1 0" range="-2.6 2.6" actuatorfrcrange="-30 30" damping="0.05"
    frictionloss="0.1"/>
  <inertial pos="0 0 -0.15" mass="0.6" diaginertia="4e-3 4e-3 1e-4"/>
</body></worldbody></mujoco>"""


def test_a_urdf_without_its_meshes_is_the_plant_of_the_same_mjcf(tmp_path):
    models = []
    for name, text in (("arm.urdf", URDF), ("arm.xml", MJCF_OF_IT)):
        (tmp_path / name).write_text(text)
        spec = plant.load(str(tmp_path / name), ["shoulder"])
        models.append(spec.compile())
    for field in (
        *("body_mass", "body_inertia", "body_ipos", "body_gravcomp", "jnt_range", "jnt_axis"),
        *("jnt_actfrcrange", "dof_damping", "dof_frictionloss", "dof_armature"),
    ):
        assert np.array_equal(getattr(models[0], field), getattr(models[1], field)), field


@pytest.mark.parametrize(
    ("was", "spoilt", "said"),
    [
        ('value="0.6"', 'value="${m}"', "xacro arm.urdf"),
        ("<inertial>", "<inertial_>", "link upper: found no <inertial>"),
        ('value="0.6"', 'value="0"', "mass and inertia"),
        ("</robot>", "", "arm.urdf: its text: found no XML"),
    ],
)
def test_a_urdf_that_is_wrong_says_why(tmp_path, was, spoilt, said):
    text = URDF.replace("<robot ", '<robot xmlns:xacro="http://wiki.ros.org/xacro" ')
    path = tmp_path / "arm.urdf"
    path.write_text(text.replace(was, spoilt).replace("</inertial>", spoilt_end(spoilt)))
    with pytest.raises(ConfigurationError, match=said):
        plant.compiled(plant.load(str(path), ["shoulder"]), str(path))


def spoilt_end(spoilt):
    return "</inertial_>" if spoilt == "<inertial_>" else "</inertial>"


INCLUDED = "<mujoco><include file='more.xml'/></mujoco>"
MESHED = (
    "<mujoco><compiler meshdir='meshes'/><asset><mesh name='m' file='more.stl'/></asset>"
    "<worldbody><body><joint name='j'/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
)


@pytest.mark.parametrize(
    ("text", "pipe"), [(None, "arm.xml"), (INCLUDED, "more.xml"), (MESHED, "meshes/more.stl")]
)
def test_a_pipe_is_not_waited_for(tmp_path, text, pipe):
    if text:
        (tmp_path / "arm.xml").write_text(text)
    (tmp_path / "meshes").mkdir()
    os.mkfifo(tmp_path / pipe)
    with pytest.raises(ConfigurationError, match=rf"{pipe}: the file: found a named pipe"):
        plant.load(str(tmp_path / "arm.xml"), ["j"])
