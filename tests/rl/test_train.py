import numpy as np
import pytest
import torch

from t2l.errors import ArtefactError
from t2l.rl.evaluate import evaluate
from t2l.rl.policy import load
from t2l.rl.train import TrainingError, _exported, _ppo, train
from tests.defaults import learning
from tests.rl.test_environments import make


@pytest.fixture(scope="module")
def trained():
    torch.set_num_threads(1)
    settings = learning(updates=30, evaluate_every=10, enough=2.0)
    environments = make(n=64, horizon_s=2.0, action_scale=(0.2, 0.1), staggered=True)
    return train(environments, make(n=50, horizon_s=2.0, action_scale=(0.2, 0.1)), settings)


def test_training_pays(trained):
    history = trained.history
    assert list(history["update"]) == [10, 20, 30]
    assert list(history.steps) == [24 * 64 * n for n in (10, 20, 30)]
    assert history.reward.iloc[-1] > history.reward.iloc[0] + 0.1
    assert history.objective.max() == pytest.approx(
        history.objective.iloc[history.objective.argmax()]
    )


def test_a_policy_acts_after_a_round_trip_as_it_did(trained, tmp_path):
    path = tmp_path / "policy.npz"
    trained.policy.save(path)
    observation = np.random.default_rng(0).normal(size=(5, 28))
    again = load(path)
    np.testing.assert_array_equal(again.act(observation), trained.policy.act(observation))
    assert again.action_scale == (0.2, 0.1)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ArtefactError, match="cannot be read"):
        load(path)


def test_without_torch_it_acts_as_with_it():
    from stable_baselines3.common.vec_env import VecNormalize

    normalised = VecNormalize(make(n=16), clip_obs=10.0)
    ppo = _ppo(normalised, seed=1)
    ppo.learn(24 * 16, log_interval=None)
    normalised.training = False
    raw = np.random.default_rng(0).normal(size=(8, 28)).astype(np.float32)
    expected, _ = ppo.predict(normalised.normalize_obs(raw), deterministic=True)
    np.testing.assert_allclose(_exported(ppo).act(raw), expected, atol=1e-5)


def test_the_same_seed_judges_a_policy_alike(trained):
    first, again = (evaluate(trained.policy, make(n=20, seed=5, horizon_s=0.4)) for _ in range(2))
    assert first == again


def test_a_policy_that_is_not_finite_ends_training():
    environments = make(n=16)
    # stands for anything that makes a loss infinite
    environments.task.weights["distance"] = np.nan
    with pytest.raises(TrainingError, match="left a policy that is not finite"):
        train(environments, make(n=4, horizon_s=0.1), learning(updates=5, evaluate_every=100))
