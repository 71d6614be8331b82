import numpy as np
import pytest
import torch

from t2l.bc.train import TrainingSettings, train
from t2l.bc.windows import Episode

SETTINGS = TrainingSettings(
    history=2,
    chunk=3,
    latent=2,
    hidden=(32, 32),
    kl_weight=0.01,
    epochs=30,
    batch_size=64,
    learning_rate=3e-3,
    weight_decay=0.0,
    observation_noise=0.0,
    validation_fraction=0.2,
)


@pytest.fixture(scope="module")
def episodes():
    """A law that a policy can learn: the action is a fixed function of the observation."""
    rng = np.random.default_rng(0)
    result = []
    for _ in range(10):
        observation = np.cumsum(0.1 * rng.normal(size=(60, 4)), axis=0)
        action = np.stack([np.sin(observation[:, 0]), 5 + observation[:, 1]], axis=1)
        result.append(Episode(observation.astype(np.float32), action.astype(np.float32)))
    return result


def test_the_same_seed_gives_the_same_weights_and_another_seed_others(episodes):
    a, losses_a = train(episodes, SETTINGS, seed=1)
    b, losses_b = train(episodes, SETTINGS, seed=1)
    c, _ = train(episodes, SETTINGS, seed=2)
    assert all(torch.equal(x, y) for x, y in zip(a.parameters(), b.parameters(), strict=True))
    assert losses_a.equals(losses_b)
    assert not all(torch.equal(x, y) for x, y in zip(a.parameters(), c.parameters(), strict=True))


def test_held_out_loss_is_recorded_per_epoch_and_falls(episodes):
    _, losses = train(episodes, SETTINGS, seed=1)
    assert losses.epoch.tolist() == list(range(1, 31))
    # 1 is the loss of always acting the mean action
    assert losses.validation_loss.iloc[-1] < 0.2
    assert losses.validation_loss.iloc[-1] < losses.validation_loss.iloc[0] / 2


def test_one_episode_cannot_be_split(episodes):
    with pytest.raises(ValueError, match="1 episodes"):
        train(episodes[:1], SETTINGS, seed=1)
