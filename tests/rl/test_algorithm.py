"""An algorithm of the user's, in a file outside the package, which brings a policy of its own."""

import numpy as np
import pytest

from t2l.policies import POLICIES, checkpoint
from t2l.registry import load_extensions
from t2l.rl.registry import ALGORITHMS
from t2l.rl.training_curves import COLUMNS, curve
from t2l.rl.trials import open_study
from t2l.rl.tune import work
from tests.defaults import learning, search
from tests.rl.test_tune import PROBLEM

FILE = '''
"""A random search over linear policies."""

import numpy as np

from t2l.policies import Policy
from t2l.rl.algorithm import Algorithm
from t2l.rl.progress import Progress


class Linear(Policy):
    name = "linear_of_a_test"
    history = chunk = 1

    def __init__(self, gain, scale):
        self.gain, self.action_scale = gain, scale
        self.action_size, self.observation_size = gain.shape

    def act(self, history):
        return np.clip(history @ self.gain.T, -1, 1)

    def tensors(self):
        return {"gain": self.gain, "scale": self.action_scale}

    def metadata(self):
        return {}

    @classmethod
    def restored(cls, tensors, metadata):
        return cls(tensors["gain"], tensors["scale"])


class RandomSearch(Algorithm):
    name = "random_search_of_a_test"

    def train(self, environments, judges, settings, report=lambda *_: None, threads=1):
        progress = Progress(judges, settings, report)
        draw = np.random.default_rng(settings.seed)
        shape = environments.action_space.shape + environments.observation_space.shape
        scale = environments.actions.scale
        for update in range(1, 1 + settings.updates):
            policy, rewards = Linear(draw.normal(size=shape), scale), []
            observation = environments.reset()
            for _ in range(5):
                observation, reward, *_ = environments.step(policy.action(observation))
                rewards.append(reward.mean())
            progress.judge(policy, update, 5 * update * len(observation), np.mean(rewards))
            if progress.enough:
                break
        return progress.trained()
'''
SETTINGS = learning(algorithm="random_search_of_a_test", environments=4, updates=3)


@pytest.fixture(scope="module", autouse=True)
def extension(tmp_path_factory):
    path = tmp_path_factory.mktemp("extensions") / "random_search.py"
    path.write_text(FILE)
    load_extensions([path])


def test_it_is_known_beside_those_of_the_library():
    assert ALGORITHMS.names() == ["ppo", "random_search_of_a_test"]


def test_it_is_tuned_and_the_policy_of_its_best_trial_kept(tmp_path):
    from t2l.rl.outcome import best

    study = open_study("journal", tmp_path / "trials.journal", "s")
    work(study, tmp_path / "store", PROBLEM, search(trials=2), SETTINGS, seed=0)
    found = best(study, tmp_path / "store", 2)
    assert type(found.policy) is POLICIES.find("linear_of_a_test")
    assert list(found.history["update"]) == [1, 2, 3]
    checkpoint.save(found.policy, tmp_path / "policy.safetensors")
    observation = np.ones((2, found.policy.observation_size))
    np.testing.assert_array_equal(
        checkpoint.load(tmp_path / "policy.safetensors").action(observation),
        found.policy.action(observation),
    )


def test_it_is_trained_again_from_other_seeds(tmp_path):
    from t2l.rl.choice import Choice

    table = curve(PROBLEM, Choice((0.1, 0.1)), SETTINGS)
    assert tuple(table.columns) == COLUMNS
    assert len(table) == 3
