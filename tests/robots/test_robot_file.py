import re

import pytest

from t2l.errors import ConfigurationError
from t2l.robots import plant
from t2l.robots.from_file import RobotFromFile
from tests.robots.test_plant import TWO_JOINTS, URDF

XACRO = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
ELBOW = 'lower="-1" upper="1.5"'
MOMENTS = 'ixx="1.1e-3" iyy="1.2e-3"'
AXIS = '<origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/>'

# what is replaced in a sound URDF, and words of the message
WRONG = {
    "an include of xacro": ('<robot name="arm">', f'{XACRO}<xacro:include filename="a.xacro"/>',
                            "<xacro:include>, as it is a xacro; allowed: what `xacro arm.urdf`"),
    "a prefix that nothing binds": ("<mimic_/>", "<xacro:arm/>", "as it is a xacro"),
    "a value to be substituted": ('effort="3"', 'effort="$(arg effort)"', r"'\$\(arg effort\)'"),
    "limits reversed": (ELBOW, 'lower="1.5" upper="-1"',
                        "joint elbow, attributes lower and upper .*1.5 and -1; .*lower below"),
    "equal limits": (ELBOW, 'lower="1" upper="1"', "joint elbow, .*found 1 and 1"),
    "a limit that is NaN": (ELBOW, 'lower="nan" upper="1"', "limit> of joint elbow.*lower.*'nan'"),
    "an axis that is NaN": (AXIS, AXIS.replace("0 1 0", "0 nan 0"), "axis> of joint elbow.*xyz"),
    "no axis": (AXIS, AXIS.replace("0 1 0", "0 0 0"), "joint elbow, attribute xyz of <axis>"),
    "half an axis": (AXIS, AXIS.replace("0 1 0", "0 1"), "xyz: found '0 1'; allowed: 3 numbers"),
    "a velocity of letters": ('effort="3" velocity="4"', 'effort="3" velocity="fast"',
                              "limit> of joint elbow, attribute velocity: found 'fast'"),
    "negative effort": ('effort="3"', 'effort="-3"', "effort: found -3; allowed: 0 or more"),
    "negative damping": ('damping="0.05"', 'damping="-0.05"', "dynamics> of joint shoulder"),
    "infinite mass": ('value="0.3"', 'value="inf"', "mass> of link lower, attribute value.*'inf'"),
    "inertia of no body": (MOMENTS, 'ixx="1" iyy="1.2e-3"', "inertia> of link lower.*principal"),
    "negative inertia": (MOMENTS, 'ixx="-1.1e-3" iyy="1.2e-3"', "inertia> of link lower"),
    "half an inertia": (MOMENTS, 'ixx="1.1e-3"', "inertia> of link lower: found no iyy"),
    "a joint twice": ('name="elbow"', 'name="shoulder"', "joint shoulder: found it twice"),
    "a link twice": ('<link name="lower">', '<link name="upper">', "link upper: found it twice"),
    "a joint without a name": ('name="elbow"', 'name=""', "a <joint>: found no name"),
}  # fmt: skip


def wrong(path, text, said):
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=said) as caught:
        plant.load(str(path), ["shoulder"])
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("case", WRONG)
def test_what_mujoco_passes_over_is_named(tmp_path, case):
    was, spoilt, said = WRONG[case]
    assert was in TWO_JOINTS
    wrong(tmp_path / "arm.urdf", TWO_JOINTS.replace(was, spoilt), said)


def test_what_urdfs_really_hold_is_taken(tmp_path):
    """What xacro leaves of itself, endless joints, parts of other programs, unknown limits."""
    path = tmp_path / "arm.urdf"
    text = TWO_JOINTS.replace('<robot name="arm">', f"{XACRO}<!-- <xacro:include/> ${{m}} -->")
    text = text.replace(ELBOW, 'lower="0" upper="0"').replace('effort="3"', 'effort="0"')
    text = text.replace('lower="-2.6" upper="2.6"', 'lower="-inf" upper="inf"')
    text = text.replace(
        "</robot>",
        '<link name="tip"/><joint name="tip" type="fixed"><parent link="lower"/><child link="tip"/>'
        '<axis xyz="0 0 0"/></joint><transmission name="t"><joint name="elbow"/>'
        '<joint name="elbow"/></transmission>'
        '<gazebo reference="lower"><mu1 value="a b"/></gazebo></robot>',
    )
    path.write_text(text)
    assert plant.load(str(path), ["shoulder", "elbow"]).compile().nv == 2


def test_a_velocity_of_zero_is_one_that_nobody_knows(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.replace('velocity="4"', 'velocity="0"'))
    with pytest.raises(ConfigurationError, match="velocity_rad_s: found nothing"):
        RobotFromFile(path)


MJCF = """<mujoco><worldbody><body name="upper"><joint name="a" axis="0 1 0" range="-9 9"/>
  <inertial pos="0 0 -1" mass="1" diaginertia="1 1 1"/>{}</body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("was", "spoilt", "said"),
    [
        ('mass="1"', 'mass="nan"', "<inertial> of body upper, attribute mass: found 'nan'"),
        ('mass="1"', 'mass="inf"', "<inertial> of body upper, attribute mass: found 'inf'"),
        ('mass="1"', 'mass="1e13"', "attribute mass: found '1e13'; allowed: finite numbers up to"),
        ('mass="1"', 'mass="1e999"', "<inertial> of body upper, attribute mass"),
        ("0 0 -1", "0 NaN -1", "attribute pos: found '0 NaN -1'; allowed: finite numbers"),
        ('range="-9 9"', 'range="9 -9"', "joint a, attribute range: found '9 -9'"),
        ('range="-9 9"', 'armature="-inf"', "joint a, attribute armature"),
    ],
)
def test_numbers_of_an_mjcf_are_finite(tmp_path, was, spoilt, said):
    path = tmp_path / "arm.xml"
    path.write_text(MJCF.format("").replace(was, spoilt))
    with pytest.raises(ConfigurationError, match=re.escape(said)):
        plant.load(str(path), ["a"])


def test_numbers_of_what_an_mjcf_includes_are_finite(tmp_path):
    (tmp_path / "part.xml").write_text('<mujocoinclude><geom size="nan"/></mujocoinclude>')
    (tmp_path / "arm.xml").write_text(MJCF.format('<include file="part.xml"/>'))
    with pytest.raises(ConfigurationError, match=r"part\.xml: <geom>, attribute size"):
        plant.load(str(tmp_path / "arm.xml"), ["a"])


def test_what_is_no_number_may_be_called_so(tmp_path):
    path = tmp_path / "arm.xml"
    text = MJCF.format('<site name="nan"/>').replace('range="-9 9"', 'range="-inf inf"')
    more = '<custom><text name="note" data="inf"/></custom><sensor><framepos objtype="site" '
    path.write_text(text.replace("</mujoco>", f'{more}objname="nan"/></sensor></mujoco>'))
    assert plant.load(str(path), ["a"]).compile().nv == 1
