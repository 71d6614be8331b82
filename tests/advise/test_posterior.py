import numpy as np
import pytest

from t2l.advise.posterior import (
    PRIOR,
    Posterior,
    Prior,
    Tried,
    best_cell,
    next_cell,
    posterior,
)

KP, KD = (values.ravel() for values in np.meshgrid([10.0, 40.0, 160.0], [1.0, 4.0]))
SCORE = np.array([3.0, 1.0, 1.5, 4.0, 1.2, 2.0])
EVERY = np.ones(6, bool)


def test_without_trainings_the_predicted_order_stands():
    found = posterior(SCORE, KP, KD)
    assert (np.argsort(-found.mean) == np.argsort(SCORE)).all()
    assert best_cell(found, EVERY) == SCORE.argmin()
    assert found.mean[1] == pytest.approx(PRIOR.middle)


def test_a_training_tells_of_its_neighbours_more_than_of_what_is_far():
    found = posterior(SCORE, KP, KD, [Tried(1, PRIOR.middle - 0.4)])
    fell = posterior(SCORE, KP, KD).mean - found.mean
    assert fell[1] > fell[4] > fell[3] > 0
    assert found.deviation[1] < found.deviation[4] < found.deviation[3]


def test_replicates_of_a_cell_are_averaged():
    """Against the formula of one unknown: weights by precision."""
    prior = Prior(middle=0.5, slope=0.0, spread=0.3, own=1e-6, length=1.0, policy=0.1)
    tried = [Tried(0, 0.9), Tried(0, 0.7)]
    found = posterior(np.ones(1), KP[:1], KD[:1], tried, prior)
    precision = 1 / 0.3**2 + 2 / 0.1**2
    assert found.mean[0] == pytest.approx((0.5 / 0.3**2 + 1.6 / 0.1**2) / precision)
    assert found.deviation[0] == pytest.approx(precision**-0.5, rel=1e-6)


def test_trainings_correct_an_order_that_is_wrong():
    truth = np.array([0.1, 0.3, 0.2, 0.4, 0.8, 0.5])
    tried = []
    for _ in range(4):
        cell = next_cell(posterior(SCORE, KP, KD, tried), EVERY)
        tried.append(Tried(cell, truth[cell]))
    assert best_cell(posterior(SCORE, KP, KD, tried), EVERY) == 4


def test_what_is_ruled_out_is_neither_trained_nor_named():
    left = EVERY.copy()
    left[1] = False
    found = posterior(SCORE, KP, KD)
    assert next_cell(found, left) != 1
    assert best_cell(found, left) == 4


def test_the_next_training_is_where_most_may_be_gained():
    mean, deviation = np.array([0.6, 0.5, 0.59]), np.array([0.01, 0.3, 0.02])
    assert next_cell(Posterior(mean, np.diag(deviation**2)), np.ones(3, bool)) == 1
