"""A world is the same on MuJoCo's arrays and on torch's."""

import numpy as np
import pytest

from t2l.environment.environment import Environment
from t2l.environment.limits import NAMES
from t2l.rl.algorithm import Trained
from t2l.rl.side_by_side import Training, learn_side_by_side
from t2l.sim.arrays import to_numpy
from tests.defaults import learning, shipped
from tests.rl.test_environments import PARAMETERS, joint_delta
from tests.rl.test_ppo_side_by_side import GOOD, PROBLEM

EACH, CELLS = 3, np.repeat([[16.0, 1.0], [512.0, 16.0]], 3, axis=0)


def make(device, **changes):
    rows = {name: np.tile(values, (2 * EACH, 1)) for name, values in PARAMETERS.items()}
    # of two cells
    rows["stiffness"], rows["damping"] = (
        np.repeat(CELLS[:, :1], 7, 1),
        np.repeat(CELLS[:, 1:], 7, 1),
    )
    scale = np.repeat([[0.3] * 7, [0.1] * 7], EACH, axis=0)
    arguments = {
        "task": shipped("joint_reach"), "kp": CELLS[:, :1], "kd": CELLS[:, 1:],
        "parameters": rows, "actions": joint_delta(scale),
        "generators": [np.random.default_rng(seed) for seed in (1, 2)], "n": EACH,
        "horizon_s": 0.4, "policy_rate_hz": 50.0, "rate_hz": 100, "staggered": False,
        "device": device,
    } | changes  # fmt: skip
    return Environment(**arguments)


def run(world, actions):
    seen, paid, ends = [to_numpy(world.begin())], [], []
    for action in actions:
        observation, reward, ended = world.advance(world.array(action))
        seen.append(to_numpy(observation))
        paid.append(to_numpy(reward))
        if ended.ids.size:
            ends.append(ended)
    return np.array(seen), np.array(paid), ends


@pytest.mark.parametrize("device", ["mujoco", "cpu"])
def test_what_the_device_knows_of_an_episodes_age_is_what_the_processor_knows(device):
    world = make(device, horizon_s=2.5, staggered=True)
    world.begin()
    assert len(set(world._elapsed)) > 1
    rest, begun = np.zeros((2 * EACH, 7)), np.zeros(2 * EACH, int)
    for _ in range(130):
        ended = world.advance(world.array(rest))[2]
        begun[ended.ids] += 1
        np.testing.assert_array_equal(to_numpy(world._age[:, 0]), world._elapsed)
    assert begun.min() == 1


@pytest.mark.parametrize("device", ["mujoco", "cpu"])
def test_a_world_made_alike_goes_on_from_a_state(device):
    # as a policy gives them; episodes end on the way
    actions = np.random.default_rng(0).normal(size=(30, 2 * EACH, 7)).astype(np.float32)
    noise = (0.01, 0.01) if device == "mujoco" else (0.0, 0.0)
    world, other = (make(device, noise=noise, staggered=True) for _ in range(2))
    world.begin()
    for action in actions:
        world.advance(world.array(action))
    other.restore(world.state())
    for action in actions:
        (seen, paid, ended), *again = (one.advance(one.array(action)) for one in (world, other))
        for one, another in zip((seen, paid, *ended), (*again[0][:2], *again[0][2]), strict=True):
            np.testing.assert_array_equal(to_numpy(another), to_numpy(one))
    np.testing.assert_equal(other.paid(), world.paid())


@pytest.fixture(scope="module")
def runs():
    actions = np.random.default_rng(0).uniform(-1.2, 1.2, (45, 2 * EACH, 7))
    return [run(make(device), actions) for device in ("mujoco", "cpu")]


def test_states_and_rewards_are_those_of_mujoco(runs):
    (expected, paid, _), (found, paid_too, _) = runs
    # dry friction: MuJoCo's first-order solver stops 3e-4 rad short of Warp's
    np.testing.assert_allclose(found[:, :, :7], expected[:, :, :7], atol=2e-3)
    np.testing.assert_allclose(paid_too, paid, atol=0.1 * 0.02)
    assert expected[:, :, :7].std() > 0.1


def test_episodes_end_alike(runs):
    ours, theirs = runs[0][2], runs[1][2]
    assert len(ours) == len(theirs) == 2
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one.ids, other.ids)
        np.testing.assert_array_equal(one.success, other.success)
        np.testing.assert_array_equal(one.violated, other.violated)
    assert one.violated.shape == (2 * EACH, len(NAMES))
    assert one.violated.any()


def test_noise_stays_within_its_bounds_on_torch_too():
    world = make("cpu", noise=(0.01, 0.02))
    exact = make("cpu")
    off = to_numpy(world.begin() - exact.begin())
    assert 0.005 < np.abs(off[:, :7]).max() <= 0.0101
    assert 0.01 < np.abs(off[:, 7:14]).max() <= 0.0201


def test_policies_train_on_torch_too():
    settings = learning(environments=8, updates=1, evaluate_every=1)
    problem = PROBLEM
    (trained,) = learn_side_by_side([Training(problem, GOOD, settings)], device="cpu")
    assert isinstance(trained, Trained)
    assert np.isfinite(trained.policy.weights[0]).all()


def test_what_each_term_pays_is_told_of_each_training_and_sums_to_the_reward():
    world = make("mujoco")
    world.begin()
    rng, rewards = np.random.default_rng(0), []
    for _ in range(7):
        rewards.append(world.advance(rng.uniform(-1, 1, (2 * EACH, 7)))[1])
    paid = world.paid()
    assert list(paid) == [term.name for term in world.task.rewards]
    expected = np.mean(rewards, axis=0).reshape(2, EACH).mean(axis=1)
    np.testing.assert_allclose(sum(paid.values()) * world.period_s, expected, rtol=1e-9)
    # told once
    assert not any(value.any() for value in world.paid().values())


def test_what_is_paid_does_not_depend_on_how_often_the_policy_acts():
    """Weights are of a second, as IsaacLab's and mjlab's managers of rewards have them."""
    returns = []
    for rate in (25.0, 50.0):
        world = make("mujoco", policy_rate_hz=rate, task=shipped("joint_reach", reward="isaaclab"))
        home = np.tile(world.task.robot.home, (2 * EACH, 1))
        world.place(home, home + 0.2)
        steps = round(0.36 * rate)
        returns.append(sum(world.advance(np.zeros((2 * EACH, 7)))[1] for _ in range(steps)))
        # what is told is of a second whatever the rate: 0.2 of the distance, and a little for it
        away = 0.2 * np.sqrt(7)
        told = world.paid()
        np.testing.assert_allclose(told["distance"], -0.2 * away, rtol=1e-4)
        np.testing.assert_allclose(sum(told.values()) * 0.36, returns[-1][::EACH], rtol=1e-4)
    np.testing.assert_allclose(*returns, rtol=1e-4)


def test_a_simulation_that_diverges_ends_its_episode_as_a_failure_and_the_others_go_on():
    world = make("mujoco", horizon_s=4.0)
    world.begin()
    world.simulator.batch.qvel[1] = np.nan
    observation, reward, ended = world.advance(np.zeros((2 * EACH, 7)))
    assert ended.ids.tolist() == [1]
    assert ended.failed.all()
    assert ended.violated.all()
    assert not ended.success.any()
    assert np.isfinite(observation).all()
    assert np.isfinite(reward).all()
    _, _, ended = world.advance(np.zeros((2 * EACH, 7)))
    assert not ended.ids.size


def test_a_training_all_of_whose_robots_diverge_is_paid_what_is_no_number():
    world = make("mujoco", horizon_s=4.0)
    world.begin()
    world.simulator.batch.qvel[:EACH] = np.nan
    reward = world.advance(np.zeros((2 * EACH, 7)))[1]
    assert np.isnan(reward[:EACH]).all()
    assert np.isfinite(reward[EACH:]).all()


@pytest.mark.parametrize(("kp", "kd"), [(1e6, 1e-4), (16.0, 1e5)])
def test_gains_are_stable_at_any_step(kp, kd):
    """The integrator is implicit in them, so that no gains are refused for the rate."""
    rows = {name: np.tile(values, (2 * EACH, 1)) for name, values in PARAMETERS.items()}
    gains = {"stiffness": np.full((2 * EACH, 7), kp), "damping": np.full((2 * EACH, 7), kd)}
    world = make("mujoco", kp=kp, kd=kd, parameters=rows | gains, rate_hz=50.0, horizon_s=4.0)
    world.begin()
    rng = np.random.default_rng(0)
    fastest = [
        world.advance(rng.uniform(-1, 1, (2 * EACH, 7))) and np.abs(world.simulator.dq).max()
        for _ in range(100)
    ]
    assert max(fastest) < 1.0
