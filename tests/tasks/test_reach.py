from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from t2l.environment.limits import NAMES as LIMITS_AND_JITTER
from t2l.errors import ConfigurationError
from t2l.figures.frames import CAMERA
from t2l.sim import make_batch
from t2l.tasks.terms import Moment
from tests.defaults import shipped
from tests.tasks.scripted import lead

NAMES = ["joint_reach", "end_effector_reach"]


def size(task):
    return len(task.error_names)


def moment(task, now, before=None, dq=None, change=None, period_s=0.02):
    """What terms see where the task has measured `now` (n, k), and `before`."""
    still = np.zeros((len(now), 7))
    return Moment(
        task, None, still, still if dq is None else dq, None, now,
        now if before is None else before, still, still if change is None else change, period_s,
    )  # fmt: skip


def reward(task, *moments, **of_moment):
    """What is paid a second."""
    at = moment(task, *moments, **of_moment)
    return sum(task.paid(at)) / at.period_s


def placed(task, q):
    """A batch with the robot at q (n, njoint)."""
    batch = make_batch(task.model, len(q))
    batch.qpos[:] = q
    return batch


@pytest.mark.parametrize("robot", ["fr3", "ur5e"])
def test_goals_lie_within_the_ranges(robot):
    task = shipped("joint_reach", robot=robot)
    goals = task.sample_goals(np.random.default_rng(0), 500)
    low, high = task.robot.position_limit.T
    assert goals.shape == (500, len(task.robot.joints))
    assert np.all(goals > low + 0.09)
    assert np.all(goals < high - 0.09)
    assert np.abs(goals - task.robot.home).max() <= task.goal_spread_rad


@pytest.mark.parametrize("robot", ["fr3", "ur5e"])
@pytest.mark.parametrize("name", NAMES)
def test_a_goal_is_met_at_the_pose_it_was_drawn_from(name, robot):
    task = shipped(name, robot=robot)
    goal = task.sample_goals(np.random.default_rng(3), 1)
    q = task.sample_joint_goals(np.random.default_rng(3), 1)
    remaining = task.measure(placed(task, q), goal)
    assert remaining.shape == (1, size(task))
    np.testing.assert_allclose(remaining, 0, atol=1e-9)
    assert task.success(moment(task, remaining))


def test_what_remains_of_a_pose_is_the_way_and_the_turn_from_here_to_there():
    task = shipped("end_effector_reach")
    data = mujoco.MjData(task.model)
    data.qpos[:] = task.robot.home
    mujoco.mj_forward(task.model, data)
    site = task.model.site(task.robot.groups[0].tool_site).id
    way, turn = np.array([0.1, -0.05, 0.02]), np.array([0.3, -0.2, 0.5])
    rotation = Rotation.from_rotvec(turn).as_matrix() @ data.site_xmat[site].reshape(3, 3)
    goal = np.concatenate([data.site_xpos[site] + way, rotation.ravel()])[None]
    remaining = task.measure(placed(task, task.robot.home[None]), goal)
    np.testing.assert_allclose(remaining[0], [*way, *turn])


@pytest.mark.parametrize(
    ("way", "solved"),
    [({}, True), ({"beside": 0.15}, False), ({"shake_rad": 0.03}, False)],
    ids=["holds the goal", "holds the last joint beside it", "shakes about it"],
)
@pytest.mark.parametrize("name", NAMES)
def test_a_scripted_arm_is_judged_right(name, way, solved):
    task = shipped(name)
    starts, goals, targets = (
        sample(np.random.default_rng(3), 4)
        for sample in (task.sample_starts, task.sample_goals, task.sample_joint_goals)
    )
    # which turns the tool, and does not move it
    targets[:, -1] += way.get("beside", 0.0)
    ended = lead(task, starts, goals, targets, way.get("shake_rad", 0.0))
    assert ended.success.tolist() == [solved] * 4
    assert ended.violated[:, LIMITS_AND_JITTER.index("jitter")].tolist() == ["shake_rad" in way] * 4


@pytest.mark.parametrize(
    ("name", "solved"),
    [("end_effector_reach", False), ("end_effector_reach_by_distance", True)],
)
def test_what_shakes_within_the_tolerance_succeeds_where_rest_is_not_asked_for(name, solved):
    task = shipped(name)
    starts, goals, targets = (
        sample(np.random.default_rng(3), 4)
        for sample in (task.sample_starts, task.sample_goals, task.sample_joint_goals)
    )
    ended = lead(task, starts, goals, targets, shake_rad=0.01)
    assert ended.success.tolist() == [solved] * 4
    assert ended.violated[:, LIMITS_AND_JITTER.index("jitter")].all()


@pytest.mark.parametrize("name", [*NAMES, "pose_hold"])
def test_what_is_seen_has_a_camera_and_moves_as_what_is_simulated(name):
    task = shipped(name)
    assert CAMERA in task.cameras
    seen = task.spec(visual=True).compile()
    assert [seen.joint(i).name for i in range(seen.njnt)] == list(task.robot.joints)


@pytest.mark.parametrize("name", NAMES)
def test_nearer_slower_and_steadier_pays_more(name):
    task = shipped(name)
    far, near = np.full((1, size(task)), 0.2), np.full((1, size(task)), 0.01)
    moving = np.full((1, 7), 0.5)
    best = reward(task, near)
    assert best > reward(task, far)
    assert best > reward(task, near, dq=moving)
    assert best > reward(task, near, change=moving)
    assert reward(task, near, far) > best > reward(task, far, near)


@pytest.mark.parametrize("name", NAMES)
def test_going_away_and_coming_back_earns_no_progress(name):
    task = shipped(name)
    path = 0.2 + 0.1 * np.sin(np.linspace(0, 2 * np.pi, 400))
    remaining = [np.full((1, size(task)), value) for value in path]
    without = task.reweighted({"progress": 0.0})
    earned = sum(
        float(reward(task, after, before)[0] - reward(without, after, before)[0])
        for before, after in pairwise(remaining)
    )
    there = reward(task, remaining[100], remaining[0])[0]
    assert abs(earned) < 0.02 * abs(float(there))


@pytest.mark.parametrize("name", NAMES)
def test_isaaclabs_reward_is_its_terms_with_its_weights(name):
    task = shipped(name, reward="isaaclab")
    remaining = np.zeros((1, size(task)))
    remaining[0, :2] = 0.03, 0.04  # 0.05 away, in the first three numbers
    dq, change = np.full((1, 7), 0.5), np.full((1, 7), 0.2)
    paid = -0.2 * 0.05 + 0.1 * (1 - np.tanh(0.5)) - 1e-3 * 7 * 0.25 - 5e-3 * 7 * 0.04
    # what was before does not count
    for before in (remaining, 2 * remaining):
        found = reward(task, remaining, before, dq=dq, change=change)
        assert found == pytest.approx(paid)
    if name == "end_effector_reach":
        turned = remaining.copy()
        turned[0, 3] = 0.3
        found = reward(task, turned, dq=dq, change=change)
        assert found == pytest.approx(paid - 0.1 * 0.3)


def test_a_weight_that_the_reward_does_not_have_is_refused():
    with pytest.raises(ConfigurationError, match="reward weights of joint_reach: found speed"):
        shipped("joint_reach").reweighted({"speed": 1.0})
