import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.robots.from_file import RobotFromFile
from tests.robots.test_plant import URDF

ARM = """<mujoco><compiler angle="radian" autolimits="true"/><worldbody>
  <body pos="0 0 1"><joint name="a" axis="0 1 0" range="-1 2"/>
    <inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.01"/>
    <body pos="0 0 -0.4"><joint name="b" axis="0 1 0"/>
      <inertial pos="0 0 -0.2" mass="1" diaginertia="0.01 0.01 0.01"/><site name="tip"/>
    </body></body>
</worldbody>
<actuator><motor joint="a" ctrlrange="-1 1" forcerange="-4 5"/><motor joint="b" forcerange="-3 3"/>
</actuator>
<keyframe><key qpos="0.5 -0.3"/></keyframe></mujoco>"""


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    return path


def test_a_file_states_joints_home_ranges_and_torques(arm):
    robot = RobotFromFile(arm, velocity_limit=[2.0, 3.0])
    assert robot.joints == ("a", "b")
    np.testing.assert_array_equal(robot.home, [0.5, -0.3])
    np.testing.assert_array_equal(robot.torque_limit, [4.0, 3.0])
    np.testing.assert_array_equal(robot.velocity_limit, [2.0, 3.0])
    np.testing.assert_array_equal(robot.position_limit, [[-1, 2], [-np.inf, np.inf]])
    assert robot.groups[0].tool_site == "tip"
    assert robot.spec().compile().nu == 2


def test_a_limit_that_nothing_states_is_asked_for(arm):
    with pytest.raises(ConfigurationError, match="velocity_rad_s: found nothing, and arm"):
        RobotFromFile(arm)


def test_a_urdf_states_velocities_and_needs_no_meshes(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(URDF)
    robot = RobotFromFile(path)
    np.testing.assert_array_equal(robot.velocity_limit, [4.0])
    np.testing.assert_array_equal(robot.torque_limit, [30.0])
    np.testing.assert_array_equal(robot.home, [0.0])
