from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from t2l.identify.training_simulator import model
from t2l.robots.kinematics import SITE
from t2l.tasks.reach import EndEffectorReach, JointReach, joint_ranges, rotation_vector


def test_goals_lie_within_the_ranges():
    goals = JointReach().sample_goals(np.random.default_rng(0), 500)
    low, high = joint_ranges().T
    assert np.all(goals > low + 0.09)
    assert np.all(goals < high - 0.09)


def test_an_end_effector_goal_is_met_at_the_pose_it_was_drawn_from():
    task = EndEffectorReach()
    goal = task.sample_goals(np.random.default_rng(3), 1)
    q = task.sample_joint_goals(np.random.default_rng(3), 1)
    arm = model()
    data = mujoco.MjData(arm)
    data.qpos[:] = q[0]
    mujoco.mj_forward(arm, data)
    site = arm.site(SITE).id
    pose = np.concatenate([data.site_xpos[site], data.site_xmat[site]])[None]
    errors = task.errors(q, pose, goal)
    np.testing.assert_allclose(errors, 0, atol=1e-9)
    assert task.success(errors)


def test_orientation_errors_are_rotations_from_here_to_there():
    turn = np.array([[0.3, -0.2, 0.5]])
    np.testing.assert_allclose(rotation_vector(Rotation.from_rotvec(turn).as_matrix()), turn)


@pytest.mark.parametrize("task", [JointReach(), EndEffectorReach()])
def test_nearer_slower_and_steadier_pays_more(task):
    far, near = np.full((1, task.errors_size), 0.2), np.full((1, task.errors_size), 0.01)
    still, moving = np.zeros((1, 7)), np.full((1, 7), 0.5)

    def reward(before, errors, dq=still, change=still):
        return task.reward(before, errors, 0.02, dq, change)

    best = reward(near, near)
    assert best > reward(far, far)
    assert best > reward(near, near, dq=moving)
    assert best > reward(near, near, change=moving)
    assert reward(far, near) > best > reward(near, far)


@pytest.mark.parametrize("task", [JointReach(), EndEffectorReach()])
def test_going_away_and_coming_back_earns_no_progress(task):
    still, period = np.zeros((1, 7)), 0.02
    path = 0.2 + 0.1 * np.sin(np.linspace(0, 2 * np.pi, 400))
    errors = [np.full((1, task.errors_size), value) for value in path]
    without = type(task)(weights={**task.weights, "progress": 0.0})
    earned = sum(
        float(
            task.reward(before, after, period, still, still)[0]
            - without.reward(before, after, period, still, still)[0]
        )
        for before, after in pairwise(errors)
    )
    there = task.reward(errors[0], errors[100], period, still, still)[0]
    assert abs(earned) < 0.02 * abs(float(there))
