"""An algorithm of the user's, in a file outside the package, which brings a policy of its own."""

import numpy as np

from t2l.policies import POLICIES, checkpoint
from t2l.rl.registry import ALGORITHMS
from t2l.rl.training_curves import COLUMNS, curve
from t2l.rl.trials import open_study
from t2l.rl.tune import work
from tests.defaults import learning, search
from tests.rl.test_tune import PROBLEM

SETTINGS = learning(algorithm="random_search", environments=4, updates=3)


def test_it_is_known_beside_those_of_the_library():
    assert set(ALGORITHMS.names()) == {"ppo", "random_search"}


def test_it_is_tuned_and_the_policy_of_its_best_trial_kept(tmp_path):
    from t2l.rl.outcome import best

    study = open_study("journal", tmp_path / "trials.journal", "s")
    work(study, tmp_path / "store", PROBLEM, search(trials=2), SETTINGS, seed=0)
    found = best(study, tmp_path / "store", 2)
    assert type(found.policy) is POLICIES.find("linear")
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
