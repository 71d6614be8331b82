from types import SimpleNamespace

import numpy as np
import pytest
import torch
from stable_baselines3.common.vec_env import VecNormalize

from t2l.policies import checkpoint
from t2l.rl.adaptive_rate import AdaptiveRate
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
    # of a second, as its terms are
    terms = history.filter(like="reward_").sum(axis=1)
    np.testing.assert_allclose(history.reward, terms, rtol=1e-4)


def test_a_policy_acts_after_a_round_trip_as_it_did(trained, tmp_path):
    checkpoint.save(trained.policy, tmp_path / "policy.safetensors")
    again = checkpoint.load(tmp_path / "policy.safetensors")
    observation = np.random.default_rng(0).normal(size=(5, 28))
    np.testing.assert_array_equal(again.action(observation), trained.policy.action(observation))
    assert again.action_scale.tolist() == [0.2] * 4 + [0.1] * 3


@pytest.mark.parametrize("clipped", [True, False], ids=["clipped", "unclipped"])
@pytest.mark.parametrize("shared", [True, False], ids=["shared", "separate"])
def test_without_torch_it_acts_as_with_it(shared, clipped):
    model = make_model(make(n=16, clipped=clipped), seed=1, shared=shared)
    model.learn(24 * 16, log_interval=None)
    normalised = model.get_env()
    assert isinstance(normalised, VecNormalize)
    normalised.training = False
    raw = np.random.default_rng(0).normal(size=(8, 28)).astype(np.float32)
    expected, _ = model.predict(normalised.normalize_obs(raw), deterministic=True)
    policy = export(model)
    assert policy.clipped == clipped
    np.testing.assert_allclose(policy.action(raw), expected, atol=1e-5)


def test_policy_and_value_share_their_hidden_layers_or_do_not():
    def hidden(shared):
        policy = make_model(make(n=4), seed=1, shared=shared).policy
        return sum(p.numel() for p in policy.parameters())

    one = 28 * 64 + 64 + 64 * 64 + 64
    heads = 64 * 7 + 7 + 64 + 1 + 7
    assert hidden(True) == one + heads
    assert hidden(False) == 2 * one + heads


def test_the_value_loss_weighs_as_in_the_study():
    assert make_model(make(n=4), seed=1).vf_coef == 1.0


def test_the_learning_rate_changes_once_an_epoch_within_skrls_bounds():
    model = make_model(make(n=4), seed=1)
    rate = AdaptiveRate(model, 1e-3, target_kl=0.01, minibatches=4)
    model.rollout_buffer.minibatch = SimpleNamespace(old_log_prob=torch.zeros(8))
    seen = []
    for log_ratio in [1.0] * 4 + [0.01] * 4 + [0.0]:
        model.policy.watch(torch.full((8,), log_ratio))
        seen.append(rate.rate)
    # e - 2 is above 0.02, 0.00005 below 0.005; each epoch is judged by its mean, when it is over
    assert seen == pytest.approx([1e-3] * 4 + [1e-3 / 1.5] * 4 + [1e-3])
    for kl, bound in ((1.0, 1e-6), (1e-3, 1e-2)):
        for _ in range(50):
            rate.adapt(kl)
        assert rate.rate == bound
        assert model.policy.optimizer.param_groups[0]["lr"] == bound


def test_the_same_seed_judges_a_policy_alike(trained):
    first, again = (evaluate(trained.policy, make(n=20, seed=5, horizon_s=0.4)) for _ in range(2))
    assert first == again


@pytest.mark.parametrize("early", [{"enough": -2.0}, {"limit_s": 1e-3}], ids=["enough", "limit"])
def test_training_ends_where_a_policy_is_good_enough_or_time_is_over(early):
    seen = []
    settings = learning(environments=8, updates=6, evaluate_every=2, **early)
    PPO.train(make(n=8), make(n=4, horizon_s=0.1), settings, lambda update, *_: seen.append(update))
    assert seen == [2]


def test_without_that_key_training_never_ends_early():
    seen = []
    settings = learning(environments=8, updates=2, evaluate_every=1)
    assert settings.enough is None
    start = make(n=4, horizon_s=0.1, action_scale=(1e-3, 1e-3))
    PPO.train(make(n=8), start, settings, lambda update, *_: seen.append(update))
    assert seen == [1, 2]


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
