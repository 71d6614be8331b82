import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.uncertainty import uncertainty
from tests.diagnose.made import pendulum, recording, swing, swings

TRUTH = np.array([0.7, -1.3])


@pytest.fixture(scope="module")
def predictor(tmp_path_factory):
    """Where samples lie in time; what they measure is made up below."""
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    return Predictor(robot, [recording(robot, swing(), str(i), duration_s=8) for i in range(3)])


def two_numbers(names=("torque_offset", "viscous_friction")):
    return Layout([Term(builtin()[name], (0,)) for name in names])


def solved(jacobian, noise, layout=None):
    """A least-squares fit of y = J u + noise that has ended."""
    change, *_ = np.linalg.lstsq(jacobian, noise, rcond=None)
    fit = LeastSquares(layout or two_numbers(), TRUTH + change, np.ones(2))
    fit.jacobian, fit.residual = jacobian, jacobian @ change - noise
    return fit


def columns(predictor):
    t = predictor.samples.time
    return np.stack([np.sin(2 * t), np.cos(5 * t) + 0.3 * np.sin(2 * t)], axis=1)


@pytest.mark.parametrize("memory_s", [0.0, 0.1])
def test_intervals_cover_the_truth(predictor, memory_s):
    """Whether the errors of neighbouring samples are alike or not."""
    jacobian, mask = columns(predictor), np.ones(len(predictor.samples), bool)
    keep = np.exp(-0.01 / memory_s) if memory_s else 0.0
    hits = 0
    for seed in range(150):
        noise = np.random.default_rng(seed).normal(size=len(jacobian))
        for i in range(1, len(noise)):
            noise[i] += keep * noise[i - 1]
        found = uncertainty(solved(jacobian, noise), predictor, mask)
        for i in range(2):
            low, high = found.interval(i)
            hits += low <= TRUTH[i] <= high
    assert 0.88 <= hits / 300 <= 0.995


def test_intervals_of_logarithms_are_intervals_of_the_number(predictor):
    layout = two_numbers(("torque_constant", "viscous_friction"))
    noise = 0.1 * np.random.default_rng(0).normal(size=len(predictor.samples))
    fit = solved(columns(predictor), noise, layout)
    found = uncertainty(fit, predictor, np.ones(len(noise), bool))
    at = next(i for i, s in enumerate(layout.slots) if s.parameter.log)
    low, high = found.interval(at)
    assert 0 < low < np.exp(fit.u[at]) < high
    assert low * high == pytest.approx(np.exp(2 * fit.u[at]))


def test_a_number_that_nothing_excites_is_named(predictor):
    jacobian = columns(predictor) * [1.0, 0.0]
    noise = np.random.default_rng(0).normal(size=len(jacobian))
    found = uncertainty(solved(jacobian, noise), predictor, np.ones(len(noise), bool))
    assert found.unexcited() == [1]
    assert np.isinf(found.error[1])
    assert np.isfinite(found.error[0])
    assert found.distance(1) == 0
    low, high = found.interval(1)
    assert (low, high) == pytest.approx((found.layout.lower[1], found.layout.upper[1]))


@pytest.mark.parametrize("apart", [1e-3, 1e-7, 0.0])
def test_two_numbers_with_the_same_trace_are_named(predictor, apart):
    """Only their sum is known; each alone may be anything."""
    first, second = columns(predictor).T
    jacobian = np.stack([first, first + apart * second], axis=1)
    noise = np.random.default_rng(0).normal(size=len(jacobian))
    found = uncertainty(solved(jacobian, noise), predictor, np.ones(len(noise), bool))
    assert found.inseparable() == [(0, 1)]
    assert (found.error > 10).all()


def test_two_numbers_with_different_traces_are_not(predictor):
    noise = np.random.default_rng(0).normal(size=len(predictor.samples))
    found = uncertainty(solved(columns(predictor), noise), predictor, np.ones(len(noise), bool))
    assert found.inseparable() == []
    assert found.unexcited() == []
    assert found.distance(0) == pytest.approx(abs(found.u[0]) / found.error[0])


def test_a_number_that_is_not_fitted_has_no_error(predictor):
    layout = two_numbers()
    noise = np.random.default_rng(0).normal(size=len(predictor.samples))
    fit = solved(columns(predictor), noise, layout)
    fit.free = np.array([True, False])
    found = uncertainty(fit, predictor, np.ones(len(noise), bool))
    assert found.error[1] == 0
    assert found.error[0] > 0


def test_a_pendulum_cannot_tell_damping_from_the_controllers(tmp_path):
    """Friction b and a Kd larger by b are one and the same where Kd never changes."""
    robot = pendulum(tmp_path)
    recordings = swings(robot, noise_rad=1e-4, duration_s=0.8, control_rate_hz=250.0)
    recordings = [recordings[1]] * 2
    predictor = Predictor(robot, recordings)
    mask = np.ones(len(predictor.samples), bool)
    layout = Layout([Term(builtin()[n], (0,)) for n in ("viscous_friction", "controller_gains")])
    fit = LeastSquares(layout, np.array([0.05, 0.0, 0.0]), np.full(3, 0.1))
    run([fit], predictor, mask, 1)
    pairs = uncertainty(fit, predictor, mask).inseparable()
    names = [{layout.slots[i].parameter.name for i in pair} for pair in pairs]
    assert {"damping", "kd_factor"} in names
