from dataclasses import replace

import numpy as np
import pytest

from t2l.errors import ConfigurationError
from t2l.rl.hyperparameters import COLUMNS, of_task
from t2l.sim import make_batch
from t2l.tasks.lift_cube import Measured
from t2l.tasks.terms import Moment
from tests.defaults import shipped
from tests.tasks.scripted import PERIOD_S, play, scene

TASK = shipped("lift_cube")
UP = np.array([0.0, 0.0, 1.0])


def lift(t, seen, goal, closes=True, beside=0.0):
    """Above the cube, down, close, to the goal."""
    if t < 1.0:
        return seen.cube + 0.1 * UP, True
    if t < 1.8:
        return seen.cube, True
    return (seen.cube if t < 2.3 else goal + np.array([beside, 0, 0])), not closes


@pytest.mark.parametrize(
    ("way", "solved"),
    [({}, True), ({"closes": False}, False), ({"beside": 0.1}, False)],
    ids=["lifts it to the goal", "does not close the hand", "holds it beside the goal"],
)
def test_a_scripted_hand_is_judged_right(way, solved):
    ended, paid = play(scene(TASK, 4), lambda *seen: lift(*seen, **way))
    assert ended.success.tolist() == [solved] * 4
    assert not ended.failed.any()
    held = way.get("closes", True)
    # a second, 1 for reaching and 15 for lifting; a goal that is met is worth up to 21 more
    assert (paid[-1] > 15 * PERIOD_S).tolist() == [held] * 4
    assert (paid[-1] > 34 * PERIOD_S).tolist() == [solved] * 4


def moment(cube, grip, goal, dq=0.0, change=0.0, steps=0):
    cube, grip, goal = (np.atleast_2d(np.asarray(point, float)) for point in (cube, grip, goal))
    away, to_go = (np.linalg.norm(end - cube, axis=1) for end in (grip, goal))
    seen = Measured(cube, grip, away, to_go)
    none = np.zeros((1, 7))
    return Moment(
        TASK, None, none, none + dq, goal, seen, action=none, change=np.zeros((1, 8)) + change,
        period_s=PERIOD_S, steps=steps,
    )  # fmt: skip


def test_rewards_are_the_published_templates():
    at = moment([0.5, 0, 0.1], [0.5, 0.1, 0.1], [0.5, 0, 0.4], dq=0.5, change=0.2)
    goal = 16 * (1 - np.tanh(1.0)) + 5 * (1 - np.tanh(6.0))
    costs = 1e-4 * (7 * 0.25 + 8 * 0.04)
    paid = 1 - np.tanh(1.0) + 15 + goal - costs
    assert sum(TASK.paid(at))[0] == pytest.approx(paid * PERIOD_S)
    later = replace(at, steps=10_000 * 4096)
    assert sum(TASK.paid(later))[0] == pytest.approx((paid - 999 * costs) * PERIOD_S)
    lying = moment([0.5, 0, 0.03], [0.5, 0, 0.03], [0.5, 0, 0.03])
    assert sum(TASK.paid(lying))[0] == pytest.approx(PERIOD_S)


def test_the_cubes_centre_decides_and_nothing_else():
    near = moment([0.5, 0, 0.3], [0, 0, 0], [0.5, 0.049, 0.3], dq=9.0)
    assert TASK.success(near).all()
    assert not TASK.success(moment([0.5, 0, 0.3], [0.5, 0, 0.3], [0.5, 0.051, 0.3])).any()


def test_a_cube_that_leaves_the_table_ends_an_episode_as_a_failure():
    environment = scene(TASK, 3)
    starts = TASK.sample_starts(np.random.default_rng(0), 3)
    goals = TASK.sample_goals(np.random.default_rng(0), 3)
    cube = TASK.model.joint("cube").qposadr[0]
    starts[1, cube] = 1.2
    environment.place(starts, goals)
    _, _, ended = environment.advance(np.zeros((3, 8)))
    assert ended.ids.tolist() == [1]
    assert ended.failed.tolist() == [True]
    assert ended.success.tolist() == [False]
    # and it has begun anew
    assert abs(environment.simulator.batch.qpos[1, cube] - 0.5) <= 0.1


def test_starts_lie_on_the_table_in_the_hands_reach_and_at_rest():
    starts = TASK.sample_starts(np.random.default_rng(0), 200)
    batch = make_batch(TASK.model, 200)
    batch.qpos[:] = starts
    TASK.command(batch.ctrl, starts[:, TASK.arm_qpos], TASK.opened)
    cube = TASK.model.joint("cube").qposadr[0]
    assert np.ptp(starts[:, cube : cube + 2], axis=0) == pytest.approx([0.2, 0.5], rel=0.05)
    batch.step(nstep=100)
    np.testing.assert_allclose(
        batch.qpos[:, cube : cube + 3], starts[:, cube : cube + 3], atol=1e-3
    )


def test_every_number_of_an_observation_has_a_name():
    environment = scene(TASK, 2)
    assert environment.observation_size == len(TASK.observation_names) + 8
    seen = environment.begin()
    names = list(TASK.observation_names)
    np.testing.assert_allclose(seen[:, names.index("cube.z")], 0.024, atol=1e-6)
    goal = seen[:, names.index("goal.x") : names.index("goal.z") + 1]
    np.testing.assert_allclose(goal, environment._goal, rtol=1e-6)


def test_the_hand_is_commanded_by_the_sign_of_an_actions_last_element():
    environment = scene(TASK, 2)
    environment.begin()
    action = np.zeros((2, 8))
    action[1, 7] = -0.01
    for _ in range(25):
        environment.advance(action)
    fingers = environment.simulator.batch.qpos[:, TASK.opening_qpos[0]]
    assert fingers[0] > 0.039
    assert fingers[1] < 0.001


def test_it_learns_with_the_studys_column():
    assert of_task(TASK) == COLUMNS["lift"]
    assert of_task(TASK).layers == (256, 128, 64)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"cube_size_m": 0.09}, "cube_size_m: found 0.09; allowed: up to 0.07"),
        ({"goal_z_m": [0.5, 0.2]}, r"goal_z_m: found \[0.5, 0.2\]; allowed: low below high"),
        ({"robot": "fr3"}, "robot: found fr3, a robot of 0 arms with a gripper; allowed: of 1"),
        ({"start_rad": [0.0, 9.0]}, r"start_rad: found \[0.0, 9.0\]; allowed: a number a joint"),
    ],
)
def test_what_cannot_be_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        shipped("lift_cube", **changes)


def test_a_column_that_the_study_has_not_is_refused():
    task = shipped("lift_cube")
    task.hyperparameters = "lifting"
    with pytest.raises(ConfigurationError, match="hyperparameters of lift_cube: found 'lifting'"):
        of_task(task)


def test_a_rate_at_which_its_contacts_do_not_hold_is_refused():
    with pytest.raises(ConfigurationError, match="found 100 Hz; allowed: from 200 Hz"):
        scene(TASK, 2, rate_hz=100.0)
