import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from t2l.rl.kinematics import SITE
from t2l.rl.reach import EndEffectorReach, JointReach, joint_ranges, rotation_vector
from t2l.sysid.simulator import model


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
    best = task.reward(near, still, still)
    assert best > task.reward(far, still, still)
    assert best > task.reward(near, moving, still)
    assert best > task.reward(near, still, moving)
