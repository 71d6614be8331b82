import numpy as np
import pytest

from t2l.actions import ACTIONS
from t2l.environment.interface import scale_per_joint
from t2l.environment.limits import NAMES, jitter
from t2l.errors import ConfigurationError
from t2l.gains import Cell
from t2l.rl.environments import Environments
from t2l.rl.evaluate import evaluate
from t2l.rl.feedback import feedback_gain
from t2l.robots import make_robot
from t2l.robots.plant import position_controlled
from t2l.sim.training_simulator import Simulator
from t2l.tasks.terms import TerminationTerm
from tests.defaults import shipped
from tests.hardware.made import Proportional

CELL = Cell(128, 16)
ROBOT = make_robot("fr3")
CENTRE = ROBOT.home
PARAMETERS = {
    name: np.full(7, value)
    for name, value in {
        "stiffness": 120.0, "damping": 15.0, "armature": 0.1, "static_friction": 0.3,
        "dynamic_friction_ratio": 0.8, "viscous_friction": 0.3,
    }.items()
}  # fmt: skip


def joint_delta(scale):
    names = [f"q_des.{joint}" for joint in ROBOT.joints]
    return ACTIONS.find("joint_delta")(names, scale, ROBOT.position_limit)


def make(task=None, n=4, **changes):
    scale = scale_per_joint(changes.pop("action_scale", (0.3, 0.2)), ROBOT)
    arguments = {
        "task": task or shipped("joint_reach"), "cell": CELL, "parameters": PARAMETERS,
        "actions": joint_delta(scale), "n": n, "seed": 0, "horizon_s": 4.0,
        "policy_rate_hz": 50.0, "rate_hz": 100, "staggered": False,
    } | changes  # fmt: skip
    return Environments(**arguments)


def test_an_action_moves_the_simulator_as_its_command_does():
    environments = make(n=1)
    start = np.array([CENTRE])
    environments.place(start, start + 0.2)
    simulator = Simulator(position_controlled(ROBOT), ROBOT.joints, ROBOT.torque_limit, 1, 100)
    simulator.set_parameters(PARAMETERS)
    simulator.q[:] = start
    action = np.linspace(-1, 1, 7)[None]
    scale = np.array([0.3] * 4 + [0.2] * 3)
    for _ in range(5):
        observation, *_ = environments.step(action)
        simulator.step(simulator.q + scale * action, nstep=2)
    np.testing.assert_allclose(observation[0, :7], simulator.q[0], rtol=1e-6)
    np.testing.assert_allclose(observation[0, 14:21], start[0] + 0.2 - simulator.q[0], rtol=1e-5)


@pytest.mark.parametrize("task", ["joint_reach", "end_effector_reach"])
def test_an_episode_ends_by_its_length_and_tells_how_it_went(task):
    environments = make(shipped(task), horizon_s=0.2)
    environments.reset()
    for step in range(10):
        observation, reward, done, infos = environments.step(np.zeros((4, 7)))
        assert done.all() == (step == 9)
    for i, info in enumerate(infos):
        assert info["TimeLimit.truncated"]
        assert not info["success"]
        assert {info[name] for name in NAMES} == {0.0}
        # a new goal, while what was seen last belongs to the old one
        assert not np.array_equal(info["terminal_observation"], observation[i])
    assert np.isfinite(reward).all()


def test_whoever_starts_at_the_goal_and_stays_succeeds():
    environments = make(horizon_s=0.2)
    start = np.tile(CENTRE, (4, 1))
    environments.place(start, start)
    for _ in range(10):
        *_, infos = environments.step(np.zeros((4, 7)))
    assert all(info["success"] for info in infos)


def test_an_episode_that_violates_once_violates():
    environments = make(cell=Cell(512, 1), action_scale=(1.0, 1.0), horizon_s=0.4)
    environments.reset()
    for k in range(20):
        action = np.full((4, 7), (-1.0) ** k)
        # the other two stand still but for one step
        action[2:] = np.eye(4, 7)[2:] * (k == 3)
        *_, infos = environments.step(action)
    assert [info["torque"] for info in infos] == [1.0] * 4
    assert [info["torque_rate"] for info in infos] == [1.0] * 4
    assert all(info["position"] == 0.0 for info in infos[2:])


def test_whoever_jitters_at_the_goal_did_not_succeed():
    environments = make(n=2, horizon_s=3.0)
    start = np.tile(CENTRE, (2, 1))
    environments.place(start, start)
    for k in range(150):
        action = np.zeros((2, 7))
        action[1, 6] = 0.5 * np.sin(2 * np.pi * 5 * k / 50)
        *_, infos = environments.step(action)
    assert [info["jitter"] for info in infos] == [False, True]
    assert [info["success"] for info in infos] == [True, False]


def test_jitter_is_that_of_the_last_seconds():
    environments = make(n=1, horizon_s=3.0)
    environments.place(start := np.array([CENTRE]), start)
    seen = []
    for k in range(149):
        environments.step(np.array([[0.3 * np.sin(k / 3), *np.zeros(6)]]))
        seen.append(environments.simulator.dq.copy())
    # the last of 150 steps is still to come: the moments are those of all ticks since 1 s
    mean, square = environments._moments / (2 * 99)
    ours = np.sqrt(square - mean**2).max()
    assert ours == pytest.approx(jitter(np.array(seen[50:]), 50.0)[0], rel=0.03)


def test_noise_is_on_what_is_observed_and_on_what_remains():
    noisy, exact = (make(n=300, noise=noise) for noise in ((0.01, 0.02), (0.0, 0.0)))
    start, goal = np.tile(CENTRE, (300, 1)), np.tile(CENTRE + 0.1, (300, 1))
    off = noisy.place(start, goal) - exact.place(start, goal)
    q, dq, remaining, action = np.split(off, [7, 14, 21], axis=1)
    for values, most in ((q, 0.01), (dq, 0.02)):
        assert 0.98 * most < np.abs(values).max() <= most + 1e-6
        assert values.std() == pytest.approx(most / np.sqrt(3), rel=0.05)
    # the goal is known; where the joints are is not
    np.testing.assert_allclose(remaining, -q, atol=1e-6)
    assert not action.any()
    np.testing.assert_array_equal(noisy.simulator.q, exact.simulator.q)


def test_actions_are_clipped_or_not():
    def moved(clipped):
        environments = make(n=1, clipped=clipped)
        environments.place(start := np.array([CENTRE]), start)
        environments.step(np.full((1, 7), 1.5))
        return (environments.simulator.q - start)[0]

    # the wrist is at its torque limit either way
    assert np.all(moved(False)[:4] > 1.3 * moved(True)[:4])


class Spring(Proportional):
    """a = g · what remains, unlimited."""

    def act(self, history):
        return self.gain * history[:, :, 2 * self.action_size : 3 * self.action_size]


@pytest.mark.parametrize("task", ["joint_reach"])
def test_the_feedback_gain_of_a_spring_is_its_stiffness_times_its_scale(task):
    policy = Spring(7, 3.0)
    policy.action_scale = np.array([0.3] * 4 + [0.2] * 3)
    found = feedback_gain(policy, make(shipped(task), n=3, horizon_s=0.2, clipped=False))
    assert found == pytest.approx(3.0 * 0.3, rel=1e-3)


def test_the_same_seed_gives_the_same_episodes_on_any_number_of_threads():
    def run(seed, threads):
        environments = make(n=8, seed=seed, threads=threads, randomisation=0.1, staggered=True)
        environments.reset()
        generator = np.random.default_rng(1)
        return [environments.step(generator.uniform(-1, 1, (8, 7)))[0] for _ in range(30)]

    np.testing.assert_array_equal(run(0, 1), run(0, 2))
    assert not np.array_equal(run(0, 1), run(1, 1))


def test_randomised_parameters_stay_within_their_fraction():
    environments = make(n=200, randomisation=0.1)
    stiffness = environments.simulator.batch.expand("actuator_gainprm")[:, :, 0]
    assert 0.9 * 120 <= stiffness.min() < 0.92 * 120
    assert 1.08 * 120 < stiffness.max() <= 1.1 * 120


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"policy_rate_hz": 30.0}, "policy rate: found 30 Hz; allowed: a divisor"),
    ],
)
def test_what_cannot_work_is_refused(change, message):
    with pytest.raises(ConfigurationError, match=message):
        make(**change)


def test_an_episode_that_fails_is_not_cut_short_by_its_length():
    """PPO counts on what would have come after an episode only where nothing but time ended it."""
    task = shipped("joint_reach")
    task.terminations = (TerminationTerm("first", lambda at: at.q[:, 0] > 0.5),)
    environments = make(task, n=2, horizon_s=0.2)
    start = np.tile(CENTRE, (2, 1))
    start[1, 0] = 0.6
    environments.place(start, start)
    *_, done, infos = environments.step(np.zeros((2, 7)))
    assert done.tolist() == [False, True]
    assert infos[1]["TimeLimit.truncated"] is False
    assert infos[1]["success"] is False
    for _ in range(9):
        *_, done, infos = environments.step(np.zeros((2, 7)))
    assert done.tolist() == [True, False]
    assert infos[0]["TimeLimit.truncated"]


def test_of_a_robot_that_fails_and_begins_anew_the_first_episode_is_judged():
    class Still:
        def action(self, observation):
            return np.zeros((len(observation), 7))

    task = shipped("joint_reach")
    task.terminations = (TerminationTerm("always", lambda at: at.q[:, 0] < 10.0),)
    found = evaluate(Still(), make(task, n=4, horizon_s=0.2))
    assert found.success == 0.0
    assert found.rates["jitter"] == 0.0
