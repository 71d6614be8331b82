"""A penalty that was chosen while something was missing is chosen again."""

from dataclasses import replace

import numpy as np

from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, coarser, refit
from t2l.propose.search import search
from t2l.propose.smoothing import smooth_again
from t2l.propose.split import split
from tests.diagnose.made import pendulum
from tests.propose.test_search import POSITIONS, machine, planted

OVER_POSITION = Law(TORQUE, "hinge", "position", "hinge")


def test_a_curve_that_bends_for_noise_gets_smoother(tmp_path):
    robot = pendulum(tmp_path)
    truth = planted(OVER_POSITION, POSITIONS, 0.04 * np.sin(3 * POSITIONS))
    predictor = Predictor(robot, machine(robot, [truth], 3), threads=1)
    samples = LearningSamples(predictor, *split(predictor))
    found = search(Model(robot), samples)
    ((effect, _),) = found.state.laws
    rough = State(found.state.layout, found.state.u, ((effect, 1e-12),))
    refit([rough], predictor, samples.fitted)
    (residual,), (error,) = samples.left_by([rough])
    bent = replace(found, state=rough, residual=residual, rmse_rad=error)
    smooth_again(bent, samples, coarser(predictor, rough))
    assert bent.state.laws[0][1] > 1e-9
    assert bent.rmse_rad <= error
    assert bent.rmse_rad < 1.1 * bent.noise_floor_rad
