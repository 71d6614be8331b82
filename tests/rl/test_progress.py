from dataclasses import replace

import numpy as np
import pytest

from t2l.environment.limits import NAMES
from t2l.policies.gaussian_mlp import GaussianMLP
from t2l.rl.progress import Progress
from t2l.rl.results import Evaluation
from t2l.rl.settings import Settings

SETTINGS = Settings("ppo", 4, 3, 1, 0, 0.0, 0.0, True, True)


def trained(settings, *evaluations):
    """What is kept of policies that are their own numbers, from (reward, success, torque rate)."""
    progress = Progress(settings, lambda *_: None)
    for i, (reward, success, rate) in enumerate(evaluations):
        rates = dict.fromkeys(NAMES, 0.0) | {"torque_rate": rate}
        progress.take(i, Evaluation(success, rates), update=i, steps=i, reward=reward)
        if progress.enough:
            break
    return progress.trained()


def test_the_policy_of_the_highest_reward_is_kept_though_one_that_does_nothing_breaks_no_limit():
    found = trained(SETTINGS, (-2.0, 0.0, 0.0), (-0.5, 0.9, 0.6), (-1.0, 0.7, 0.5))
    assert (found.policy, found.evaluation.success) == (1, 0.9)
    assert found.history.objective.idxmax() == 0


def test_what_is_good_enough_to_end_a_training_is_what_it_ends_with():
    enough = replace(SETTINGS, enough=0.8)
    assert trained(enough, (-0.5, 0.2, 0.0), (-0.6, 0.9, 0.0), (-0.1, 0.0, 0.0)).policy == 1


@pytest.mark.parametrize(("limit_s", "ends"), [(98, True), (101, False), (None, False)])
def test_a_training_ends_where_one_more_evaluation_would_come_too_late(limit_s, ends):
    settings, found = replace(SETTINGS, limit_s=limit_s), Evaluation(0, dict.fromkeys(NAMES, 0.0))
    policy = GaussianMLP(
        *(np.zeros(1), np.ones(1), [np.zeros((1, 1))], [np.zeros(1)], np.ones(1)), clipped=True
    )
    before = Progress(settings, lambda *_: None)
    before.take(policy, found, update=8, steps=8, reward=-1.0)
    # the ninth of evaluations that come every 10 s; what was spent before a kill counts
    state = before.state() | {"seconds": 90, "history": 8 * [{"seconds": 80}]}
    after = Progress(settings, lambda *_: None)
    after.restore(state)
    after.take(None, found, update=9, steps=9, reward=-2.0)
    assert after.enough == ends
    # ended by time alone, it is still the policy of the highest reward
    assert after.trained().policy is not None


def test_what_each_term_paid_is_told_and_kept(caplog):
    progress = Progress(SETTINGS, lambda *_: None)
    found = Evaluation(0.5, dict.fromkeys(NAMES, 0.0))
    terms = {"reaching": 0.75, "change": -0.25}
    with caplog.at_level("INFO"):
        progress.take(0, found, update=3, steps=9, reward=0.5, terms=terms)
    told = "update 3: success 0.50, ended early 0.00; reward 0.5 = reaching 0.75 + change -0.25"
    assert told in caplog.messages
    row = progress.trained().history.iloc[0]
    assert (row.reward_reaching, row.reward_change) == (0.75, -0.25)


def test_a_reward_that_is_no_number_is_the_least():
    assert (
        trained(SETTINGS, (float("nan"), 0.0, 0.0), (-1.0, 0.5, 0.0), (-2.0, 0.9, 0.0)).policy == 1
    )
