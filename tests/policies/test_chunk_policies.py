import subprocess
import sys

import numpy as np
import pytest
import torch

from t2l.config import effective
from t2l.policies import POLICIES, Episode, TrainingSet
from t2l.policies.validation import prediction_mse, split
from t2l.typed import Invalid
from tests.policies.made import (
    CHUNK_POLICIES,
    Reused,
    chunk_policy,
    episodes,
    fitted,
    settings,
)

kinds = pytest.mark.parametrize("kind", CHUNK_POLICIES)


def same(one, other):
    first, second = one.tensors(), other.tensors()
    return all(np.array_equal(first[name], second[name]) for name in first)


@kinds
def test_the_same_seed_gives_the_same_weights_and_another_seed_others(kind):
    a, losses_a = fitted(episodes(), seed=1, kind=kind, epochs=3)
    b, losses_b = fitted(episodes(), seed=1, kind=kind, epochs=3)
    c, _ = fitted(episodes(), seed=2, kind=kind, epochs=3)
    assert same(a, b)
    assert losses_a.equals(losses_b)
    assert not same(a, c)


@kinds
def test_networks_side_by_side_come_out_as_each_alone(kind):
    few = settings(kind, epochs=3, observation_noise=0.1)
    sets = [TrainingSet(*split(episodes(), 0.2, seed), seed) for seed in (1, 2, 3)]
    together = POLICIES.find(kind).fit_side_by_side(sets, few)
    history = np.stack([e.observation[:2] for e in episodes()])
    for one, (policy, losses) in zip(sets, together, strict=True):
        alone, its_losses = POLICIES.find(kind).fit(one.training, one.validation, few, one.seed)
        # not the weights: one that changes no answer, as attention has, moves by rounding alone
        np.testing.assert_allclose(policy.act(history), alone.act(history), atol=1e-4)
        np.testing.assert_allclose(losses.validation_loss, its_losses.validation_loss, rtol=1e-4)


@kinds
def test_a_training_step_keeps_nothing_of_what_the_next_one_overwrites(kind, monkeypatch):
    few = settings(kind, epochs=2, observation_noise=0.1)
    sets = [TrainingSet(*split(episodes(), 0.2, seed), seed) for seed in (1, 2)]
    expected = POLICIES.find(kind).fit_side_by_side(sets, few)
    monkeypatch.setattr("t2l.policies.training.Captured", Reused)
    history = np.stack([e.observation[:2] for e in episodes()])
    found = POLICIES.find(kind).fit_side_by_side(sets, few)
    for (policy, losses), (same, its_losses) in zip(expected, found, strict=True):
        np.testing.assert_array_equal(policy.act(history), same.act(history))
        assert losses.equals(its_losses)


@kinds
def test_held_out_loss_is_recorded_per_epoch_and_falls(kind):
    policy, losses = fitted(episodes(), kind=kind)
    assert losses.epoch.tolist() == list(range(1, 31))
    # 1 is the loss of always acting the mean action
    assert losses.validation_loss.iloc[-1] < 0.2
    assert losses.validation_loss.iloc[-1] < losses.validation_loss.iloc[0] / 2
    assert (policy.history, policy.chunk) == (2, 3)


@kinds
def test_what_others_draw_and_compute_is_left_alone(kind):
    torch.manual_seed(5)
    threads, expected = torch.get_num_threads(), torch.rand(3)
    torch.manual_seed(5)
    few = settings(kind, epochs=1)
    policy, _ = POLICIES.find(kind).fit(
        episodes()[:4], episodes()[4:6], few, seed=1, threads=threads + 1
    )
    policy.act(np.ones((1, 2, 4)))
    assert torch.equal(torch.rand(3), expected)
    assert torch.get_num_threads() == threads
    assert not torch.are_deterministic_algorithms_enabled()
    assert not torch.backends.cuda.matmul.allow_tf32


@kinds
def test_a_policy_acts_in_physical_units(kind):
    policy, _ = fitted(episodes(), kind=kind, epochs=5)
    chunk = policy.act(np.random.default_rng(0).normal(size=(6, 2, 4)))
    assert chunk.shape == (6, 3, 2)
    # the second action of the demonstrations is about 5
    assert np.abs(chunk[:, :, 1] - 5).max() < 3


@kinds
def test_an_element_that_never_changes_is_not_divided_by_zero(kind):
    still = [Episode(np.ones((20, 4), np.float32), np.ones((20, 2), np.float32))] * 3
    policy, _ = fitted(still, kind=kind, epochs=1)
    assert np.isfinite(policy.act(np.ones((1, 2, 4)))).all()
    assert np.isfinite(policy.act(np.full((1, 2, 4), 1e6))).all()


def two_ways(count=40, length=60):
    """The same thing is seen, and one of two is done for as long as an episode lasts."""
    rng = np.random.default_rng(1)
    ways = np.sign(rng.normal(size=count))
    return [
        Episode(
            rng.normal(size=(length, 4)).astype(np.float32),
            np.full((length, 2), way, np.float32),
        )
        for way in ways
    ]


def test_only_samples_go_one_of_two_ways():
    """Of what is demonstrated in two ways, a mean is neither."""
    history = np.random.default_rng(2).normal(size=(400, 2, 4))
    answers = {
        kind: fitted(two_ways(), kind=kind, epochs=40, learning_rate=1e-2)[0].act(history)
        for kind in ("chunk_regression", "chunk_diffusion")
    }
    assert np.abs(answers["chunk_regression"]).mean() < 0.5
    sampled = answers["chunk_diffusion"]
    assert np.mean(np.abs(np.abs(sampled) - 1) < 0.3) > 0.9
    # both ways, and a whole chunk one of them
    assert 0.2 < np.mean(sampled > 0) < 0.8
    assert np.mean(np.abs(np.sign(sampled).mean(axis=(1, 2))) == 1) > 0.9


def test_a_sample_is_reproduced_by_the_same_calls_alone():
    policy, history = chunk_policy("chunk_diffusion"), np.ones((1, 2, 4))
    first, second = policy.act(history), policy.act(history)
    again = type(policy).restored(policy.tensors(), policy.metadata())
    np.testing.assert_array_equal(again.act(history), first)
    np.testing.assert_array_equal(again.act(history), second)
    assert not np.array_equal(first, second)


def test_a_network_of_ones_own_is_all_that_it_takes():
    from t2l.policies.chunk_network import ChunkNetwork
    from t2l.policies.chunk_policy import ChunkPolicy, ChunkSettings, ChunkSizes

    class Linear(ChunkNetwork):
        def make(self, sizes, settings):
            self.layer = torch.nn.Linear(self.history_size, self.chunk_size)

        def error(self, condition, target):
            squared = (self.answer(condition) - target).square().mean()
            return squared, squared

        def answer(self, condition):
            return self.layer(condition)

    class Own(ChunkPolicy):
        name, settings, sizes, network_class = "own", ChunkSettings, ChunkSizes, Linear

    few = ChunkSettings(
        history=1, chunk=1, epochs=60, batch_size=32, learning_rate=3e-2, observation_noise=0
    )
    training, validation = split(episodes(), 0.2, 1)
    policy, _ = Own.fit(training, validation, few, seed=1)
    # of the two actions the second is linear in what is seen
    curved, linear = prediction_mse(policy, validation)
    assert 10 * linear < curved
    again = Own.restored(policy.tensors(), policy.metadata())
    np.testing.assert_array_equal(again.act(np.ones((1, 1, 4))), policy.act(np.ones((1, 1, 4))))


def test_a_width_that_heads_do_not_divide_is_told():
    section = {"policy": "chunk_transformer", "width": 100, "heads": 3}
    with pytest.raises(Invalid, match=r"training: .*a width that is a multiple of heads"):
        effective({"study": "tests", "training": section})


@kinds
def test_settings_and_names_cost_no_torch(kind):
    code = (
        "import sys; from t2l.policies import POLICIES, checkpoint\n"
        f"POLICIES.find({kind!r}).settings(); POLICIES.find('gaussian_mlp')\n"
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr


@pytest.mark.parametrize("epochs", [1, 9, 10, 11])
def test_a_training_of_few_steps_ends(epochs):
    _, losses = fitted(episodes(), epochs=epochs, batch_size=1000)
    assert len(losses) == epochs
