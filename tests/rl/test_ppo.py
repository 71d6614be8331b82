import numpy as np
import pytest
import torch
from stable_baselines3.common.vec_env import VecNormalize

from t2l.policies import checkpoint
from t2l.rl.algorithm import TrainingError
from t2l.rl.evaluate import evaluate
from t2l.rl.ppo import export, make_model
from t2l.rl.registry import ALGORITHMS
from tests.defaults import learning, shipped
from tests.rl.test_environments import make

PPO = ALGORITHMS.find("ppo")()


@pytest.fixture(scope="module")
def trained():
    settings = learning(updates=30, evaluate_every=10, enough=2.0)
    environments = make(n=64, horizon_s=2.0, action_scale=(0.2, 0.1), staggered=True)
    return PPO.train(environments, make(n=50, horizon_s=2.0, action_scale=(0.2, 0.1)), settings)


def test_training_pays(trained):
    history = trained.history
    assert list(history["update"]) == [10, 20, 30]
    assert list(history.steps) == [24 * 64 * n for n in (10, 20, 30)]
    assert history.reward.iloc[-1] > history.reward.iloc[0] + 0.1
    assert history.objective.max() == trained.evaluation.objective


def test_a_policy_acts_after_a_round_trip_as_it_did(trained, tmp_path):
    checkpoint.save(trained.policy, tmp_path / "policy.safetensors")
    again = checkpoint.load(tmp_path / "policy.safetensors")
    observation = np.random.default_rng(0).normal(size=(5, 28))
    np.testing.assert_array_equal(again.action(observation), trained.policy.action(observation))
    assert again.action_scale.tolist() == [0.2] * 4 + [0.1] * 3


def test_without_torch_it_acts_as_with_it():
    model = make_model(make(n=16), seed=1)
    model.learn(24 * 16, log_interval=None)
    normalised = model.get_env()
    assert isinstance(normalised, VecNormalize)
    normalised.training = False
    raw = np.random.default_rng(0).normal(size=(8, 28)).astype(np.float32)
    expected, _ = model.predict(normalised.normalize_obs(raw), deterministic=True)
    np.testing.assert_allclose(export(model).action(raw), expected, atol=1e-5)


def test_the_same_seed_judges_a_policy_alike(trained):
    first, again = (evaluate(trained.policy, make(n=20, seed=5, horizon_s=0.4)) for _ in range(2))
    assert first == again


def test_training_ends_where_a_policy_is_good_enough():
    seen = []
    settings = learning(environments=8, updates=6, evaluate_every=2, enough=-2.0)
    PPO.train(make(n=8), make(n=4, horizon_s=0.1), settings, lambda update, _: seen.append(update))
    assert seen == [2]


def test_a_policy_that_is_not_finite_ends_training():
    # stands for anything that makes a loss infinite
    environments = make(shipped("joint_reach").reweighted({"distance": np.nan}), n=16)
    judges = make(n=4, horizon_s=0.1)
    with pytest.raises(TrainingError, match="update 1 left a policy that is not finite"):
        PPO.train(environments, judges, learning(updates=5, evaluate_every=100))
    with pytest.raises(TrainingError, match="update 1 left a policy that is not finite"):
        PPO.train(environments, judges, learning(updates=1, evaluate_every=100))


def test_what_others_compute_with_torch_is_left_alone(trained):
    threads = torch.get_num_threads()
    PPO.train(make(n=8), make(n=4, horizon_s=0.1), learning(updates=1), threads=threads + 1)
    assert torch.get_num_threads() == threads
    with pytest.raises(ValueError, match="parameter"):
        torch.distributions.Normal(torch.nan, 1.0)
