import subprocess
import sys

import numpy as np
import torch

from t2l.policies import POLICIES, Episode, TrainingSet
from t2l.policies.validation import split
from tests.policies.made import chunk_cvae, episodes, fitted, settings

POLICY = POLICIES.find("chunk_cvae")


def same(one, other):
    first, second = one.tensors(), other.tensors()
    return all(np.array_equal(first[name], second[name]) for name in first)


def test_the_same_seed_gives_the_same_weights_and_another_seed_others():
    a, losses_a = fitted(episodes(), seed=1, epochs=3)
    b, losses_b = fitted(episodes(), seed=1, epochs=3)
    c, _ = fitted(episodes(), seed=2, epochs=3)
    assert same(a, b)
    assert losses_a.equals(losses_b)
    assert not same(a, c)


def test_networks_side_by_side_come_out_as_each_alone():
    few = settings(epochs=3, observation_noise=0.1)
    sets = [TrainingSet(*split(episodes(), 0.2, seed), seed) for seed in (1, 2, 3)]
    together = POLICY.fit_side_by_side(sets, few)
    for one, (policy, losses) in zip(sets, together, strict=True):
        alone, its_losses = POLICY.fit(one.training, one.validation, few, one.seed)
        for name, weights in alone.tensors().items():
            np.testing.assert_allclose(policy.tensors()[name], weights, atol=1e-5)
        np.testing.assert_allclose(losses.validation_loss, its_losses.validation_loss, rtol=1e-4)


def test_held_out_loss_is_recorded_per_epoch_and_falls():
    policy, losses = fitted(episodes())
    assert losses.epoch.tolist() == list(range(1, 31))
    # 1 is the loss of always acting the mean action
    assert losses.validation_loss.iloc[-1] < 0.2
    assert losses.validation_loss.iloc[-1] < losses.validation_loss.iloc[0] / 2
    assert (policy.history, policy.chunk) == (2, 3)


def test_what_others_draw_and_compute_is_left_alone_by_training():
    torch.manual_seed(5)
    threads, expected = torch.get_num_threads(), torch.rand(3)
    torch.manual_seed(5)
    POLICY.fit(episodes()[:4], episodes()[4:6], settings(epochs=1), seed=1, threads=threads + 1)
    assert torch.equal(torch.rand(3), expected)
    assert torch.get_num_threads() == threads
    assert not torch.are_deterministic_algorithms_enabled()


def test_a_policy_acts_in_physical_units():
    policy = chunk_cvae()
    chunk = policy.act(np.random.default_rng(0).normal(size=(6, 2, 4)))
    assert chunk.shape == (6, 3, 2)
    # the second action of the demonstrations is about 5
    assert np.abs(chunk[:, :, 1] - 5).max() < 2


def test_an_element_that_never_changes_is_not_divided_by_zero():
    still = [Episode(np.ones((20, 4), np.float32), np.ones((20, 2), np.float32))] * 3
    policy, _ = fitted(still, epochs=1)
    assert np.isfinite(policy.act(np.ones((1, 2, 4)))).all()
    assert np.isfinite(policy.act(np.full((1, 2, 4), 1e6))).all()


def test_settings_and_names_cost_no_torch():
    code = (
        "import sys; from t2l.policies import POLICIES, checkpoint\n"
        "POLICIES.find('chunk_cvae').settings(); POLICIES.find('gaussian_mlp')\n"
        "print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr
