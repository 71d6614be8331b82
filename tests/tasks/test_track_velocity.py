from dataclasses import replace

import mujoco
import numpy as np
import pytest

from t2l.environment.limits import LIMITS
from t2l.environment.vector import make_vector
from t2l.gains import Cell
from t2l.rl.hyperparameters import COLUMNS, of_task
from t2l.sim.batch import make_batch
from t2l.tasks.disturbance import Disturbance
from t2l.tasks.terms import Moment
from t2l.tasks.track_velocity import TEMPLATE, Measured
from tests.defaults import shipped
from tests.tasks.scripted import until_they_end

TASK = shipped("track_velocity")
JOINTS = len(TASK.robot.joints)
HOME_ACTIONS = {"kind": "joint_delta", "reference": "home"}
STILL = np.zeros((4, JOINTS))
GOALS = np.array([[1.0, 0.0, 0.0], [0.3, 0.4, 0.5], [0.5, -0.2, -3.0], [0.0, 0.5, 1.0]])


def scene(n=4, horizon_s=1.0, **of_environment):
    return make_vector(
        TASK, Cell(1, 1), (0.5, 0.5), n, horizon_s, actions=HOME_ACTIONS, **of_environment
    ).environment


class Carried(Disturbance):
    """Robots are carried upright over the ground, with a share of the velocity they are to have."""

    def __init__(self, environment, share):
        self.environment, self.share = environment, share

    def apply(self, time_s):
        batch, goal = self.environment.simulator.batch, self.environment._goal
        pose, twist = batch.qpos[:, TASK.base_qpos], batch.qvel[:, TASK.base_dofs]
        # the heading that is asked for from the start on
        half = goal[:, 2] / 2
        pose[:, 2] = TASK.walker.height_m
        pose[:, 3:] = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
        cos, sin = np.cos(goal[:, 2]), np.sin(goal[:, 2])
        twist[:] = 0.0
        twist[:, 0] = self.share * (cos * goal[:, 0] - sin * goal[:, 1])
        twist[:, 1] = self.share * (sin * goal[:, 0] + cos * goal[:, 1])
        # what of its fall the ground is not to see
        twist[:, 2] = 9.81 * self.environment.period_s / 2


def play(environment):
    """The episodes' end, and the rewards until then (nstep, n)."""
    environment.place(TASK.sample_starts(np.random.default_rng(0), 4), GOALS)
    return until_they_end(environment, lambda _: STILL)


@pytest.mark.parametrize(
    ("share", "solved"), [(1.0, True), (0.5, True), (0.3, False), (0.0, False)]
)
def test_who_is_carried_is_judged_by_the_share_of_the_velocity(share, solved):
    environment = scene()
    environment.disturbance = Carried(environment, share)
    ended, _ = play(environment)
    assert ended.success.tolist() == [solved] * 4
    assert not ended.failed.any()
    # its fingers rest against their stops
    assert not ended.violated.any()
    paid = environment.paid()
    # 1 a second is all there is for the velocity
    assert (paid["velocity"] > 0.9) == (share == 1.0)
    assert paid["fall"] == 0.0


def test_who_is_let_go_falls_and_its_episode_ends_as_a_failure():
    environment = scene(horizon_s=5.0)
    ended, paid = play(environment)
    assert len(paid) < environment.horizon
    assert ended.failed.all()
    assert not ended.success.any()
    assert ended.violated[:, LIMITS.index("position")].all()
    # a fall costs 200 · 0.02 s, once
    assert np.all(paid[-1] < -3.9)
    assert np.all(paid[:-1] > -0.5)


def moment(**changed):
    """Of a robot at home that does what it is asked for, and stands."""
    zero = np.zeros((1, 2))
    seen = Measured(
        velocity=np.array([[0.6, -0.2]]), linear=np.zeros((1, 3)), angular=np.zeros((1, 3)),
        gravity=np.array([[0.0, 0.0, -1.0]]), turning=np.array([0.3]),
        command=np.array([[0.6, -0.2, 0.3]]), stands=zero == 0, slip=zero,
        fallen=np.zeros(1, bool), effort=np.zeros(1), jerking=np.zeros(1), held_s=zero + 0.3,
    )  # fmt: skip
    home = TASK.robot.home[None]
    at = Moment(
        TASK, None, home, 0 * home, np.array([[0.6, -0.2, 1.0]]), seen,
        action=0 * home, change=0 * home, period_s=0.02,
    )  # fmt: skip
    own = {key: changed.pop(key) for key in list(changed) if key in Measured._fields}
    return replace(at, now=seen._replace(**own), **changed)


def paid(at):
    """A second's worth of each term that is not zero."""
    values = [float(value[0]) / at.period_s for value in TASK.paid(at)]
    named = zip((term.name for term in TASK.rewards), values, strict=True)
    return {name: value for name, value in named if abs(value) > 1e-12}


def test_rewards_are_the_published_template():
    assert {term.source for term in TASK.rewards} == {TEMPLATE}
    assert paid(moment()) == pytest.approx({"velocity": 1.0, "turn": 1.0})
    one = np.array([[True, False]])
    assert paid(moment(stands=one))["stepping"] == pytest.approx(0.75 * 0.3)
    # the foot that has changed last counts, and no more than 0.4 s of it
    assert paid(moment(stands=one, held_s=np.array([[0.9, 0.7]])))["stepping"] == pytest.approx(0.3)
    slow = np.array([[0.05, 0.0, 0.3]])
    assert "stepping" not in paid(moment(stands=one, command=slow))
    off = moment(velocity=np.array([[0.1, -0.2]]), turning=np.array([0.8]))
    assert paid(off) == pytest.approx({"velocity": np.exp(-1), "turn": np.exp(-1)})
    tilted = moment(
        gravity=np.array([[0.3, 0.4, -0.87]]), angular=np.array([[1.0, 2.0, 9.0]]),
        linear=np.array([[5.0, 5.0, 0.5]]), slip=np.array([[0.2, 0.1]]), fallen=np.ones(1, bool),
        effort=np.array([1e4]), jerking=np.array([1e5]), change=np.full((1, JOINTS), 0.1),
    )  # fmt: skip
    costs = {
        "upright": 0.25, "tilting": 0.25, "bouncing": 0.05, "slip": 0.03, "fall": 200.0,
        "torque": 0.02, "acceleration": 0.01, "change": 0.005 * JOINTS * 0.01,
    }  # fmt: skip
    found = paid(tilted)
    assert {name: -found[name] for name in costs} == pytest.approx(costs)


def test_joints_away_from_home_cost_by_their_set():
    q = TASK.robot.home + 0.2
    found = paid(moment(q=q[None]))
    sizes = {"hips": 4 * 0.1, "arms": 10 * 0.1, "fingers": 14 * 0.05, "waist": 0.1}
    assert {name: -found[name] for name in sizes} == pytest.approx(
        {name: 0.2 * size for name, size in sizes.items()}
    )
    # an ankle turns by ±0.2618 rad, of which the last tenth costs
    roll = TASK.robot.joints.index("left_ankle_roll_joint")
    q = TASK.robot.home.copy()
    q[roll] = 0.26
    assert -paid(moment(q=q[None]))["ankles"] == pytest.approx(0.26 - 0.9 * 0.2618)


def test_a_robot_knows_its_own_motion_and_is_told_to_turn_to_its_heading():
    rng = np.random.default_rng(0)
    batch = make_batch(TASK.model, 3)
    starts = TASK.sample_starts(rng, 3)
    starts[:, TASK.base_qpos][:, 3:] += 0.3 * rng.normal(size=(3, 4))
    quaternion = starts[:, TASK.base_qpos][:, 3:]
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    batch.qpos[:], batch.qvel[:, TASK.base_dofs] = starts, rng.normal(size=(3, 6))
    goal = np.array([[1.0, 0.2, 0.1], [0.5, 0.1, 3.0], [0.1, 0.1, -3.0]])
    seen = TASK.measure(batch, goal)
    base = TASK.model.joint(TASK.walker.base).id
    body = TASK.model.jnt_bodyid[base]
    for i in range(3):
        data = batch.get_data(i)
        mujoco.mj_forward(TASK.model, data)
        own, world = np.empty((2, 6))
        kind = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(TASK.model, data, kind, body, own, 1)
        mujoco.mj_objectVelocity(TASK.model, data, kind, body, world, 0)
        np.testing.assert_allclose(seen.angular[i], own[:3], atol=1e-9)
        np.testing.assert_allclose(seen.linear[i], own[3:], atol=1e-9)
        assert seen.turning[i] == pytest.approx(world[2])
        axes = data.xmat[body].reshape(3, 3)
        np.testing.assert_allclose(seen.gravity[i], axes.T @ [0, 0, -1], atol=1e-9)
        yaw = np.arctan2(axes[1, 0], axes[0, 0])
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        left = np.array([-np.sin(yaw), np.cos(yaw)])
        np.testing.assert_allclose(
            seen.velocity[i], [ahead @ world[3:5], left @ world[3:5]], atol=1e-9
        )
        away = np.angle(np.exp(1j * (goal[i, 2] - yaw)))
        np.testing.assert_allclose(seen.command[i], [*goal[i, :2], np.clip(away / 2, -1, 1)])


def test_how_long_a_foot_stands_or_swings_is_carried_on_and_begins_anew():
    def seen(*stands):
        return moment(stands=np.array([stands] * 2)).now._replace(
            fallen=np.zeros(2, bool), effort=np.zeros(2), jerking=np.zeros(2),
            slip=np.zeros((2, 2)), held_s=None,
        )  # fmt: skip

    nobody = np.zeros(0, int)
    now = TASK.follow(seen(True, True), None, 0.0, np.arange(2))
    for stands in ([False, True],) * 3:
        now = TASK.follow(seen(*stands), now, 0.02, nobody)
    np.testing.assert_allclose(now.held_s, [[0.06, 0.06]] * 2)
    now = TASK.follow(seen(True, True), now, 0.02, nobody)
    np.testing.assert_allclose(now.held_s, [[0.02, 0.08]] * 2)
    # what is looked at twice has not lasted longer; who begins has nothing behind it
    now = TASK.follow(seen(True, True), now, 0.0, np.array([1]))
    np.testing.assert_allclose(now.held_s, [[0.02, 0.08], [0.0, 0.0]])
    assert not now.stands[1].any()


def test_every_number_of_an_observation_has_a_name():
    environment = scene(2)
    assert environment.observation_size == len(TASK.observation_names) + JOINTS
    assert TASK.robot_observation_size == 2 * JOINTS + 9
    seen, names = environment.begin(), list(TASK.observation_names)
    np.testing.assert_allclose(seen[:, names.index("down.z")], -1.0)
    np.testing.assert_allclose(seen[:, names.index("command.x")], environment._goal[:, 0])
    assert not TASK.deployable


def test_success_asks_for_the_studys_share_of_speed_and_for_no_direction():
    goal = np.array([[0.5, 0.0, 0.0]])
    for velocity, solved in (([0.21, 0.0], True), ([0.19, 0.0], False), ([-0.3, 0.0], True)):
        at = moment(velocity=np.array([velocity]), goal=goal)
        assert TASK.success(at).tolist() == [solved]


def test_it_learns_with_the_studys_column():
    assert of_task(TASK) == COLUMNS["g1"]
    assert of_task(TASK).layers == (256, 128, 128)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"robot": "fr3"}, "robot: found fr3, which does not walk; allowed: one that does"),
        ({"forward_m_s": [1.0, 0.2]}, r"forward_m_s: found \[1.0, 0.2\]; allowed: low below high"),
    ],
)
def test_what_cannot_be_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        shipped("track_velocity", **changes)
