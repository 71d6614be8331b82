"""Trials of a real study, with objectives made up."""

import optuna
import pytest

from t2l.rl.tuning import HopelessPruner


@pytest.fixture
def study():
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna.create_study(direction="maximize", pruner=HopelessPruner(3, 100))


def ended(study, objectives):
    """At which update a trial is ended; None for one that is completed."""
    trial = study.ask()
    for update, objective in objectives.items():
        trial.report(objective, update)
        if trial.should_prune():
            study.tell(trial, state=optuna.trial.TrialState.PRUNED)
            return update
    study.tell(trial, objective)
    return None


FAILING = dict.fromkeys((20, 40, 60, 80, 100), 0.0)


def test_failing_trials_end_half_way_even_where_most_of_them_fail(study):
    # the first is completed whatever it does, so that there is a policy
    assert ended(study, FAILING) is None
    assert [ended(study, FAILING) for _ in range(5)] == [60] * 5


def test_a_trial_that_keeps_the_limits_or_learns_late_is_completed(study):
    assert ended(study, FAILING) is None
    # constraints kept and no success yet
    assert ended(study, dict.fromkeys((20, 40, 60, 80, 100), 1.0)) is None
    assert ended(study, {20: 0.0, 40: 0.0, 60: 0.2, 80: 1.5, 100: 1.9}) is None


def test_what_is_worse_than_the_median_ends_early(study):
    for _ in range(3):
        assert ended(study, dict.fromkeys((20, 40, 60, 80, 100), 1.9)) is None
    assert ended(study, dict.fromkeys((20, 40, 60, 80, 100), 1.2)) == 40
