from dataclasses import replace

import mujoco
import numpy as np
import pytest

from t2l.environment.vector import make_vector
from t2l.gains import Cell
from t2l.rl.hyperparameters import COLUMNS, of_task
from t2l.sim.batch import make_batch
from t2l.tasks.disturbance import Disturbance
from t2l.tasks.in_hand_cube import TEMPLATE
from t2l.tasks.poses import about, conjugate, product
from t2l.tasks.terms import Moment
from tests.defaults import shipped
from tests.tasks.scripted import until_they_end

TASK = shipped("in_hand_cube")
JOINTS = len(TASK.robot.joints)
HOME_ACTIONS = {"kind": "joint_delta", "reference": "home"}
YAW = np.array([1.5, -1.5, 0.8, -0.8])
GOALS = about(2, YAW)
STILL = np.zeros((4, JOINTS))


def scene(n=4, horizon_s=1.0, cell=(1, 1), **of_environment):
    return make_vector(
        TASK, Cell(*cell), (0.5, 0.5), n, horizon_s, actions=HOME_ACTIONS, **of_environment
    ).environment


class Turned(Disturbance):
    """Cubes are held above the palm and turned, by a share of the angle they are to have."""

    def __init__(self, environment, share, beside_m=0.0):
        self.environment, self.share, self.beside_m = environment, share, beside_m

    def apply(self, time_s):
        batch, share = self.environment.simulator.batch, self.share
        position, palm = TASK.palm_pose
        cube = batch.qpos[:, TASK.cube_qpos]
        cube[:, :3] = position + np.array([self.beside_m, 0, 0.12])
        # there after half a second
        angle = share * YAW * np.minimum(1.0, 2 * time_s)
        cube[:, 3:] = product(np.tile(palm, (4, 1)), about(2, angle))
        batch.qvel[:, TASK.cube_dofs] = 0.0


def play(environment):
    """The episodes' end, and the rewards until then (nstep, n)."""
    environment.place(TASK.sample_starts(np.random.default_rng(0), 4), GOALS)
    return until_they_end(environment, lambda _: STILL)


@pytest.mark.parametrize(
    ("share", "solved"), [(1.0, True), (0.95, True), (0.5, False), (0.0, False)]
)
def test_a_cube_that_is_turned_is_judged_by_how_far(share, solved):
    environment = scene()
    environment.disturbance = Turned(environment, share)
    ended, paid = play(environment)
    assert ended.success.tolist() == [solved] * 4
    assert not ended.failed.any()
    # 250 a second, of periods of 0.02 s, are what a goal is worth
    assert (paid[-1] > 5.0).tolist() == [solved] * 4


@pytest.mark.parametrize("cell", [(0.25, 0.25), (0.25, 4), (4, 0.25), (4, 4)])
def test_at_rest_the_cube_stays_in_the_hand_and_is_no_success(cell):
    environment = scene(cell=cell, horizon_s=2.0)
    ended, _ = play(environment)
    assert not ended.failed.any()
    assert not ended.success.any()
    # it has settled, as it began
    at = environment._before
    assert np.all(at.cube[:, 2] < 0.04)


def test_a_cube_beside_the_hand_falls_and_its_episode_ends_as_a_failure():
    environment = scene(horizon_s=2.0)
    environment.place(TASK.sample_starts(np.random.default_rng(0), 4), GOALS)
    # once, in its orientation; half a second is enough to fall
    Turned(environment, 1.0, beside_m=0.2).apply(1.0)
    for _ in range(25):
        _, _, ended = environment.advance(STILL)
        if ended.ids.size:
            break
    assert ended.failed.all()
    assert not ended.success.any()


def moment(**changed):
    """Of a hand at home whose cube is at its goal."""
    environment = scene(1)
    environment.place(TASK.sample_starts(np.random.default_rng(0), 1), about(2, np.zeros(1)))
    home = TASK.robot.home[None]
    at = Moment(
        TASK, None, home, 0 * home, about(2, np.zeros(1)), environment._before,
        action=0 * home, change=0 * home, period_s=0.02,
    )  # fmt: skip
    own = {key: changed.pop(key) for key in list(changed) if key in at.now._fields}
    return replace(at, now=at.now._replace(**own), **changed)


def paid(at):
    """A second's worth of each term that is not zero."""
    values = [float(value[0]) / at.period_s for value in TASK.paid(at)]
    named = zip((term.name for term in TASK.rewards), values, strict=True)
    return {name: value for name, value in named if abs(value) > 1e-12}


def test_rewards_are_the_published_template():
    assert {term.source for term in TASK.rewards} == {TEMPLATE}
    there = {"orientation": 1 / 0.1, "success": 250.0}
    assert paid(moment()) == pytest.approx(there, abs=1e-6)
    assert paid(moment(away_rad=np.array([0.4]))) == pytest.approx({"orientation": 2.0})
    one = np.ones((1, JOINTS))
    costs = {"velocity": 2.5e-5 * JOINTS * 4, "action": 1e-4 * JOINTS, "change": 1e-2 * JOINTS * 9}
    found = paid(moment(dq=2 * one, action=one, change=3 * one))
    assert {name: -found[name] for name in costs} == pytest.approx(costs)


def test_what_is_measured_is_in_the_frame_of_thepalm_pose():
    rng = np.random.default_rng(0)
    batch = make_batch(TASK.model, 3)
    batch.qpos[:] = TASK.sample_starts(rng, 3)
    cube = batch.qpos[:, TASK.cube_qpos]
    cube[:, 3:] = rng.normal(size=(3, 4))
    cube[:, 3:] /= np.linalg.norm(cube[:, 3:], axis=1, keepdims=True)
    batch.qvel[:, TASK.cube_dofs] = rng.normal(size=(3, 6))
    goal = TASK.sample_goals(rng, 3)
    seen = TASK.measure(batch, goal)
    for i in range(3):
        data = mujoco.MjData(TASK.model)
        data.qpos[:] = batch.qpos[i]
        mujoco.mj_kinematics(TASK.model, data)
        palm = data.site(TASK.robot.palm)
        axes = palm.xmat.reshape(3, 3)
        np.testing.assert_allclose(seen.cube[i, :3], axes.T @ (cube[i, :3] - palm.xpos), atol=1e-9)
        np.testing.assert_allclose(seen.linear[i], axes.T @ batch.qvel[i, TASK.cube_dofs][:3])
        turn, wanted = np.empty(9), np.empty(9)
        mujoco.mju_quat2Mat(turn, seen.cube[i, 3:])
        body = data.body("cube").xmat.reshape(3, 3)
        np.testing.assert_allclose(turn.reshape(3, 3), axes.T @ body, atol=1e-9)
        mujoco.mju_quat2Mat(wanted, goal[i])
        cosine = (np.trace(wanted.reshape(3, 3) @ turn.reshape(3, 3).T) - 1) / 2
        assert seen.away_rad[i] == pytest.approx(np.arccos(np.clip(cosine, -1, 1)), abs=1e-6)
        assert seen.away[i, 0] >= 0
    back = product(seen.away, seen.cube[:, 3:])
    np.testing.assert_allclose(np.abs((back * goal).sum(axis=1)), 1.0)


def test_goals_are_turned_about_the_normal_alone_unless_more_is_asked_for():
    rng = np.random.default_rng(0)
    goals = TASK.sample_goals(rng, 500)
    np.testing.assert_array_equal(goals[:, 1:3], 0.0)
    assert np.abs(2 * np.arctan2(goals[:, 3], goals[:, 0])).max() == pytest.approx(1.57, abs=0.02)
    template = shipped("in_hand_cube", yaw_rad=0.0, tilt_rad=3.15)
    goals = template.sample_goals(rng, 500)
    np.testing.assert_allclose(np.linalg.norm(goals, axis=1), 1.0)
    # the cube's own z is anywhere
    height = 1 - 2 * (goals[:, 1] ** 2 + goals[:, 2] ** 2)
    assert height.min() < -0.9 < 0.9 < height.max()
    np.testing.assert_allclose(
        product(goals, conjugate(goals)), np.tile([1.0, 0, 0, 0], (500, 1)), atol=1e-12
    )


def test_every_number_of_an_observation_has_a_name():
    environment = scene(2)
    assert environment.observation_size == len(TASK.observation_names) + JOINTS
    assert TASK.robot_observation_size == 2 * JOINTS
    seen, names = environment.begin(), list(TASK.observation_names)
    np.testing.assert_allclose(seen[:, names.index("goal.w")], environment._goal[:, 0], atol=1e-6)
    assert not TASK.deployable


def test_it_learns_with_isaaclabs_column():
    assert of_task(TASK) == COLUMNS["hand"]
    assert of_task(TASK).layers == (512, 256, 128)


def test_what_is_no_hand_is_refused():
    with pytest.raises(ValueError, match="robot: found fr3, which is no hand; allowed: one that"):
        shipped("in_hand_cube", robot="fr3")
