"""A robot of one's own is identified, learned on and deployed on."""

import numpy as np
import pytest

from t2l.environment.limits import NAMES
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.rl.problem import Choice, Condition, Problem
from t2l.robots import make_robot
from tests.defaults import learning, shipped

PARAMETERS = {
    name: np.full(3, value)
    for name, value in {
        "stiffness": 120.0, "damping": 15.0, "armature": 0.05, "static_friction": 0.1,
        "dynamic_friction_ratio": 0.8, "viscous_friction": 0.1,
    }.items()
}  # fmt: skip


def test_a_robot_is_known_by_its_name_with_all_its_limits():
    robot = make_robot("three_joint_arm")
    assert robot.joints == ("turn", "lift", "bend")
    np.testing.assert_array_equal(robot.position_limit, np.tile([-2.5, 2.5], (3, 1)))
    assert robot.proximal.tolist() == [True, False, False]
    with pytest.raises(ConfigurationError, match=r"robot: found 'three_joint' \(did you mean"):
        make_robot("three_joint")


@pytest.mark.parametrize("name", ["joint_reach", "end_effector_reach"])
def test_it_reaches_in_an_identified_simulator(name):
    task = shipped(name, robot="three_joint_arm")
    condition = Condition(
        name=name, task=name, policy_rate_hz=50.0, randomisation=0.1,
        actions={"kind": "joint_delta"},
        parameters={
            "kind": name, "robot": "three_joint_arm", "start_spread_rad": 0.1,
            "goal_spread_rad": 0.4,
        } | (
            {"tolerance_rad": 0.1} if name == "joint_reach"
            else {"position_tolerance_m": 0.02, "orientation_tolerance_rad": 0.1}
        ),
    )  # fmt: skip
    problem = Problem(condition, Cell(128, 16), PARAMETERS, rate_hz=100.0, horizon_s=1.0)
    environments = problem.environments(Choice((0.3, 0.2)), learning(), 4, seed=0)
    observation = environments.reset()
    assert observation.shape == (4, len(task.observation_names) + 3)
    for _ in range(environments.horizon):
        observation, reward, done, infos = environments.step(np.zeros((4, 3)))
    assert done.all()
    assert np.isfinite(reward).all()
    assert {info[constraint] for info in infos for constraint in NAMES} == {0.0}
