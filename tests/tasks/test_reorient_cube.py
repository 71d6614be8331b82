import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from t2l.tasks.poses import tilted, upright
from tests.defaults import shipped
from tests.tasks.scripted import RATE_HZ, scene, towards

TASK = shipped("reorient_cube")
START, GOAL = np.array([0.45, 0.0, 0.03]), np.array([0.57, 0.0, 0.03])
FLAT = np.zeros(1)


def pushed(goal, behind=0.045):
    """The end of an episode whose hand goes down behind the cube and then forward."""
    environment = scene(TASK, 1)
    starts = TASK.sample_starts(np.random.default_rng(0), 1)
    starts[:, TASK.object_qpos] = upright(START[None], FLAT)
    environment.place(starts, goal)
    for step in range(environment.horizon):
        t = step / RATE_HZ
        forward = min(max(t - 2.5, 0.0) * 0.1, GOAL[0] - START[0])
        hand = START + np.array([forward - behind, 0.0, 0.1 * max(1.5 - t, 0.0) / 1.5 + 0.005])
        action = towards(environment, hand[None], True)
        ended = environment.advance(action)[2]
    return ended.success.tolist()


@pytest.mark.parametrize(
    ("goal", "behind", "solved"),
    [
        (upright(GOAL[None], FLAT), 0.045, True),
        (upright(GOAL[None], FLAT), 0.25, False),
        (upright(GOAL[None], FLAT + 0.5), 0.045, False),
        (tilted(GOAL[None], FLAT, FLAT + np.pi / 2), 0.045, False),
    ],
    ids=["pushes it there", "stays clear of it", "does not turn it", "does not tip it"],
)
def test_a_scripted_hand_is_judged_right(goal, behind, solved):
    assert pushed(goal, behind) == [solved]


def test_goals_lie_on_the_table_on_a_face_and_some_on_another_one():
    goals = TASK.sample_goals(np.random.default_rng(0), 400)
    np.testing.assert_allclose(goals[:, 2], 0.03)
    up = Rotation.from_quat(goals[:, 3:], scalar_first=True).as_matrix()[:, 2, 2]
    tipped = np.abs(up) < 1e-9
    assert tipped.mean() == pytest.approx(0.25, abs=0.06)
    np.testing.assert_allclose(up[~tipped], 1.0)


def test_the_turn_that_is_left_is_the_angle_between_the_orientations():
    environment = scene(TASK, 3)
    rng = np.random.default_rng(1)
    starts, goals = TASK.sample_starts(rng, 3), TASK.sample_goals(rng, 3)
    # a quaternion and its negative are one orientation
    goals[2, 3:] *= -1
    environment.place(starts, goals)
    seen = TASK.measure(environment.simulator.batch, goals)
    here, there = (
        Rotation.from_quat(poses[:, -4:], scalar_first=True) for poses in (starts, goals)
    )
    np.testing.assert_allclose(seen.turn_rad, (there * here.inv()).magnitude(), atol=1e-6)


def test_the_hand_is_closed_and_no_action_opens_it():
    environment = scene(TASK, 2)
    environment.begin()
    assert len(environment.action_names) == 7
    for _ in range(25):
        environment.advance(np.zeros((2, 7)))
    assert environment.simulator.batch.qpos[:, TASK.opening_qpos[0]].max() < 0.001


def test_rewards_rise_to_the_goal():
    environment = scene(TASK, 2)
    starts = TASK.sample_starts(np.random.default_rng(0), 2)
    goals = starts[:, TASK.object_qpos].copy()
    goals[1] = TASK.sample_goals(np.random.default_rng(3), 1)[0]
    environment.place(starts, goals)
    reward = environment.advance(np.zeros((2, 7)))[1] / environment.period_s
    # a second, all but reaching: 8 + 8 + 10
    assert 25.5 < reward[0] < 27
    assert reward[1] < reward[0] - 5
