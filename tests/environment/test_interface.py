import pytest

from t2l.environment.interface import observation_names, scale_per_joint, steps_held
from t2l.errors import ConfigurationError
from t2l.robots import make_robot
from tests.defaults import shipped


def test_an_action_is_held_for_whole_steps():
    assert steps_held(100.0, 50.0, "the simulator's") == 2
    with pytest.raises(ConfigurationError, match="policy rate: found 30 Hz"):
        steps_held(100.0, 30.0, "the simulator's")


@pytest.mark.parametrize(("robot", "proximal"), [("fr3", 4), ("ur5e", 3)])
def test_joints_near_the_base_share_a_scale_and_the_others_another(robot, proximal):
    scale = scale_per_joint((0.3, 0.1), make_robot(robot))
    assert scale.tolist() == [0.3] * proximal + [0.1] * (len(scale) - proximal)


@pytest.mark.parametrize("name", ["joint_reach", "end_effector_reach"])
def test_every_number_of_an_observation_has_a_name(name):
    task = shipped(name)
    names = observation_names(task)
    njoint = len(task.robot.joints)
    assert len(set(names)) == len(names)
    assert names[2 * njoint].startswith("error.")
    assert names[-njoint:] == [f"action.{joint}" for joint in task.robot.joints]
