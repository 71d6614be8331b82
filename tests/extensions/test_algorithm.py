"""An algorithm of the user's, in a file outside the package, which brings a policy of its own."""

import numpy as np
import pytest

from t2l.environment.interface import observation_names, scale_per_joint
from t2l.policies import POLICIES, checkpoint
from t2l.rl.learn import gain_of, judge
from t2l.rl.registry import ALGORITHMS
from t2l.rl.side_by_side import Training, policies_of
from t2l.rl.trials import best, open_study
from t2l.rl.tuning import work
from tests.defaults import learning, search
from tests.rl.test_tuning import PROBLEM

SETTINGS = learning(algorithm="random_search", environments=4, updates=3)


def test_it_is_known_beside_those_of_the_library():
    assert set(ALGORITHMS.names()) == {"ppo", "random_search"}


def _gain(policy):
    """Of a linear policy that is nowhere at its bound: the norm of α (∂π/∂q − ∂π/∂error)."""
    names = observation_names(PROBLEM.task)
    q, error = (
        policy.gain[:, [name.startswith(prefix) for name in names]] for prefix in ("q.", "error.")
    )
    return np.linalg.norm(policy.action_scale[:, None] * (q - error), ord=2)


def test_it_is_tuned_trained_and_its_policy_kept(tmp_path):
    study = open_study("journal", tmp_path / "trials.journal", "s")
    work(study, PROBLEM, search(trials=2), SETTINGS, seed=0)
    choice = best(study, PROBLEM.task.robot, 2).choice
    [(trained, evaluation, gain)] = policies_of([Training(PROBLEM, choice, SETTINGS)])
    # it is judged as it would be alone, with the action scales that tuning chose
    assert evaluation == judge(PROBLEM, choice, SETTINGS, trained.policy)
    scale = scale_per_joint(choice.action_scale, PROBLEM.task.robot)
    np.testing.assert_allclose(trained.policy.action_scale, scale)
    # a policy that answers to no joint has no feedback gain, and this one is another
    nothing = type(trained.policy)(0 * trained.policy.gain, trained.policy.action_scale)
    assert gain_of(PROBLEM, choice, SETTINGS, nothing) == 0
    assert gain == pytest.approx(gain_of(PROBLEM, choice, SETTINGS, trained.policy))
    gentle = type(trained.policy)(1e-3 * trained.policy.gain, trained.policy.action_scale)
    assert gain_of(PROBLEM, choice, SETTINGS, gentle) == pytest.approx(_gain(gentle), rel=1e-3)
    assert type(trained.policy) is POLICIES.find("linear")
    assert list(trained.history["update"]) == [1, 2, 3]
    checkpoint.save(trained.policy, tmp_path / "policy.safetensors")
    observation = np.ones((2, trained.policy.observation_size))
    np.testing.assert_array_equal(
        checkpoint.load(tmp_path / "policy.safetensors").action(observation),
        trained.policy.action(observation),
    )
