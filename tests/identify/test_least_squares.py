import numpy as np
import pytest

from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from tests.diagnose.made import hold, pendulum, recording, swing, swings


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def test_a_parameter_stays_within_its_bounds(robot):
    """The data ask for less than no friction."""
    effects = {"coulomb_friction": {"torque": {"hinge": 0.0}}}
    recordings = swings(robot, effects, 1e-4, 0.8, control_rate_hz=250.0)
    predictor = Predictor(robot, recordings)
    seen = []

    def watch(fits):
        seen.extend(fit.u.copy() for fit in fits)

    layout = Layout([Term(builtin()["quadratic_friction"], (0,))])
    fit = LeastSquares(layout, np.array([0.05]), np.array([0.05]))
    run([fit], predictor, np.ones(len(predictor.samples), bool), 12, watch)
    assert (np.array(seen) >= 0).all()
    assert fit.u[0] == pytest.approx(0.0, abs=2e-3)


def test_a_fit_that_cannot_start_ends(robot):
    """From a point where every simulation diverges."""
    predictor = Predictor(robot, [recording(robot, swing(), kd=0.8, duration_s=0.5)])
    mask = np.ones(len(predictor.samples), bool)
    layout = Layout([Term(builtin()["controller_gains"], (0,))])
    wild = LeastSquares(layout, np.log([10.0, 1e3]), np.ones(2))
    wild.layout.upper[:] = 20.0
    healthy = LeastSquares(
        Layout([Term(builtin()["viscous_friction"], (0,))]), np.array([0.1]), np.ones(1)
    )
    with np.errstate(all="ignore"):
        run([wild, healthy], predictor, mask, 10)
    assert wild.done
    assert not np.isfinite(wild.loss)
    assert np.isfinite(healthy.loss)
    assert healthy.iterations > 0


def drive(fit, residual_at, rounds=60):
    """Answer a fit's questions by a function of u until it is done."""
    joints = np.arange(len(residual_at(fit.u))) % 2
    for _ in range(rounds):
        if fit.done:
            return
        points = fit.points()
        assert (points >= fit.layout.lower).all()
        assert (points <= fit.layout.upper).all()
        fit.receive(np.array([residual_at(u) for u in points]), joints)


def two_offsets(start=(1.0, 1.0)):
    return LeastSquares(
        Layout([Term(builtin()["torque_offset"], (0, 1))]), np.array(start), np.ones(2)
    )


A = np.random.default_rng(0).normal(size=(40, 2))


def test_a_linear_problem_is_solved_in_a_few_rounds():
    fit, truth = two_offsets(), np.array([0.3, -2.0])
    drive(fit, lambda u: A @ (u - truth) + 1e-4)
    assert fit.u == pytest.approx(truth, abs=1e-3)
    assert fit.iterations <= 6


def test_an_angle_that_does_nothing_at_first_does_not_hold_the_other_back():
    """As a base that leans to the side: no derivative at zero, and so the wildest step."""
    layout = Layout([Term(builtin()["base_tilt"], (0, 1))])
    fit = LeastSquares(layout, np.array([0.0, 0.03]), np.full(2, 0.02))

    def residual(u):
        roll, pitch = np.cos(u[0]) - np.cos(0.05), np.sin(u[1]) - np.sin(0.1)
        return A @ np.array([roll, pitch])

    drive(fit, residual)
    assert np.abs(fit.u) == pytest.approx([0.05, 0.1], abs=1e-3)


def test_a_step_into_divergence_is_not_taken():
    """Half of the space explodes, and the best point lies close to its edge."""
    fit, truth = two_offsets(), np.array([0.3, -2.0])
    exploded = []

    def residual(u):
        if u[0] < 0.25:
            exploded.append(u)
            return np.full(len(A), np.nan)
        return np.tanh(A @ (u - truth))

    drive(fit, residual)
    assert fit.done
    assert exploded
    assert fit.u == pytest.approx(truth, abs=0.05)


def test_a_fit_whose_every_trial_explodes_stays_and_ends():
    fit = two_offsets()
    drive(fit, lambda u: A @ u if (u == 1.0).all() or (u != 1.0).sum() == 1 else A @ u * np.nan)
    assert fit.done
    assert fit.u == pytest.approx([1.0, 1.0])
    assert fit.loss == pytest.approx(np.mean((A @ np.ones(2)) ** 2))


@pytest.mark.parametrize("huge", [1e9, 1e200])
def test_a_huge_derivative_leaves_numbers(huge):
    """A simulation next to the point may be anything."""
    fit = two_offsets()
    with np.errstate(all="ignore"):
        drive(fit, lambda u: A @ u if u[0] == 1.0 else np.full(len(A), huge))
    assert np.isfinite(fit.u).all()


def test_a_parameter_that_nothing_excites_ends_the_fit(robot):
    """An arm at rest in its zero tells nothing about friction in motion."""
    predictor = Predictor(robot, [recording(robot, hold(0.0), duration_s=0.3)])
    layout = Layout([Term(builtin()["viscous_friction"], (0,))])
    fit = LeastSquares(layout, np.array([0.1]), np.array([0.1]))
    run([fit], predictor, np.ones(len(predictor.samples), bool), 50)
    assert fit.u == pytest.approx([0.1])
    assert np.isfinite(fit.u).all()


def test_the_last_round_asks_for_no_derivatives_that_nobody_needs():
    """And ends where it would have ended with them."""
    ends, asked = [], []
    for last in (None, 2):
        fit = two_offsets()
        fit.last = last
        rounds = []
        while fit.starting or fit.iterations < 2:
            points = fit.points()
            rounds.append(len(points))
            fit.receive(np.array([bent(u) for u in points]), np.zeros(len(A), int))
        ends.append(fit.u)
        asked.append(rounds)
    assert (ends[0] == ends[1]).all()
    assert asked[1] == [*asked[0][:-1], asked[0][-1] - 2]


def bent(u):
    return A @ u + 0.1 * (A**2) @ u**2
