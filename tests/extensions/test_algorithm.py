"""An algorithm of the user's, in a file outside the package, which brings a policy of its own."""

import numpy as np

from t2l.policies import POLICIES, checkpoint
from t2l.rl.outcome import best
from t2l.rl.registry import ALGORITHMS
from t2l.rl.side_by_side import Training, policies_of
from t2l.rl.trials import open_study
from t2l.rl.tune import work
from tests.defaults import learning, search
from tests.rl.test_tune import PROBLEM

SETTINGS = learning(algorithm="random_search", environments=4, updates=3)


def test_it_is_known_beside_those_of_the_library():
    assert set(ALGORITHMS.names()) == {"ppo", "random_search"}


def test_it_is_tuned_trained_and_its_policy_kept(tmp_path):
    study = open_study("journal", tmp_path / "trials.journal", "s")
    work(study, PROBLEM, search(trials=2), SETTINGS, seed=0)
    choice = best(study, PROBLEM.task.robot, 2).choice
    [(trained, evaluation, gain)] = policies_of([Training(PROBLEM, choice, SETTINGS)])
    assert 0 <= evaluation.objective <= 2
    assert gain >= 0
    assert type(trained.policy) is POLICIES.find("linear")
    assert list(trained.history["update"]) == [1, 2, 3]
    checkpoint.save(trained.policy, tmp_path / "policy.safetensors")
    observation = np.ones((2, trained.policy.observation_size))
    np.testing.assert_array_equal(
        checkpoint.load(tmp_path / "policy.safetensors").action(observation),
        trained.policy.action(observation),
    )
