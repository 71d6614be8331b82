"""Without a wrong name, a curve that undid it is the constant that it stands for."""

import numpy as np
import pytest

from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.bases import effect_of
from t2l.propose.elimination import eliminate
from t2l.propose.found import Search
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.proposal import finished
from t2l.propose.refit import State, refit, with_law
from t2l.propose.split import split
from tests.diagnose.made import pendulum
from tests.propose.test_search import POSITIONS, machine, planted

SPRING = {"parallel_spring": {"stiffness": {"hinge": 0.05}, "rest": {"hinge": 0.3}}}


def undone(wrong, samples):
    """A torque over position that undoes what is wrong, and adds what is missing."""
    predictor, law = samples.predictor, Law(TORQUE, "hinge", "position", "hinge")
    effect = effect_of(law, (POSITIONS[0], POSITIONS[-1]), 0.3)
    weights = np.zeros(len(effect.parameters))
    state = with_law(State(*wrong.vector(("hinge",))), effect, weights, 1.0, ("hinge",))
    refit([state], predictor, samples.fitted)
    (residual,), (error,) = samples.left_by([state])
    return Search(state, error, error, 1e-4, residual)


def found_beside_a_spring(robot, curve):
    predictor = Predictor(robot, machine(robot, [curve], 3), threads=1)
    samples = LearningSamples(predictor, *split(predictor))
    wrong = Model(robot, SPRING)
    found, dropped = eliminate(undone(wrong, samples), ["parallel_spring"], samples)
    assert dropped == ["parallel_spring"]
    return finished(wrong, found, predictor, None, samples.fitted | samples.chosen)


def test_a_constant_takes_the_place_of_a_curve_that_only_undid_a_spring(tmp_path):
    constant = planted(
        Law(TORQUE, "hinge", "constant", "hinge"), np.array([0.0, 1.0]), np.full(2, 0.04)
    )
    found = found_beside_a_spring(pendulum(tmp_path), constant)
    (one,) = found.learned
    assert one.curve.law == constant.law
    np.testing.assert_allclose(one.curve.torque, 0.04, rtol=0.02)


def test_a_curve_that_bends_without_the_spring_stays(tmp_path):
    law = Law(TORQUE, "hinge", "position", "hinge")
    ripple = planted(law, POSITIONS, 0.04 * np.sin(5 * POSITIONS))
    (one,) = found_beside_a_spring(pendulum(tmp_path), ripple).learned
    assert one.curve.law == law


def test_a_straight_line_takes_the_place_of_a_curve_that_need_not_bend(tmp_path):
    law = Law(TORQUE, "hinge", "position", "hinge")
    line = planted(law, POSITIONS, 0.03 - 0.02 * POSITIONS)
    (one,) = found_beside_a_spring(pendulum(tmp_path), line).learned
    assert one.curve.law == law
    slopes = np.diff(one.curve.torque) / np.diff(one.curve.at)
    np.testing.assert_allclose(slopes, slopes.mean(), rtol=1e-9)
    assert slopes.mean() == pytest.approx(-0.02, rel=0.05)
