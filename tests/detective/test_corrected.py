"""Fits by the corrected model along the motion, against fits with derivatives by simulation."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.detective.along_motion import AlongMotion
from t2l.detective.corrected import fit_corrected
from t2l.detective.data_split import split
from t2l.detective.fitted_set import Start
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import PositionError as Positions
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from tests.detective.test_along_motion import NOISE_RAD, along_of
from tests.diagnose.made import pendulum, swings

HIDDEN = {
    "coulomb_friction": {"torque": {"hinge": 0.1}},
    "torque_constant": {"factor": {"hinge": 0.7}},
}


class Counted(Positions):
    """Counts the variants that are simulated."""

    variants = 0

    def residuals(self, asked):
        self.variants += sum(len(points) for _, points in asked)
        return super().residuals(asked)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    return split(
        robot, swings(robot, HIDDEN, NOISE_RAD, duration_s=2.0), swings(robot)[:1], threads=1
    )


def _start(torque: float, factor: float) -> Start:
    """At guesses of what is hidden."""
    layout = Layout([Term(builtin()[name], (0,)) for name in HIDDEN])
    guess = {
        "coulomb_friction": {"torque": np.array([torque])},
        "torque_constant": {"factor": np.array([factor])},
    }
    return Start(layout, layout.encode(guess))


def test_few_simulations_reach_the_minimum_of_the_simulated_error(data):
    start = _start(torque=0.03, factor=0.95)
    layout = start.layout
    along, _ = along_of(data)
    simulated = Counted(data.fitted, data.fitted_mask)
    (found,) = fit_corrected([start], along, simulated, data.folds, 5)
    assert simulated.variants <= 6
    fit = LeastSquares(layout, start.u.copy(), np.abs(start.u) + 0.1)
    run([fit], data.fitted, data.fitted_mask, 20)
    assert found.rmse == pytest.approx(np.sqrt(fit.loss), rel=0.02)
    assert found.rmse < 1.2 * NOISE_RAD
    theta = layout.decode(found.u[None])
    assert theta["coulomb_friction"]["torque"][0, 0] == pytest.approx(0.1, rel=0.02)
    assert theta["torque_constant"]["factor"][0, 0] == pytest.approx(0.7, rel=0.02)
    assert found.rmse <= found.left_out_rmse < 1.2 * found.rmse


def test_a_start_that_runs_away_is_left_out_and_the_others_go_on(data):
    """A spring that pushes away: the pendulum leaves."""
    effect = builtin()["parallel_spring"]
    layout = Layout([Term(effect, (0,))])
    starts = [Start(layout, np.array([0.0, 0.0])), Start(layout, np.array([-1e9, 0.0]))]
    along, _ = along_of(data)
    simulated = Positions(data.fitted, data.fitted_mask)
    (lost,) = simulated.residuals([(starts[1], starts[1].u[None])])
    assert not np.isfinite(lost).all()
    (found,) = fit_corrected(starts, along, simulated, data.folds, 3)
    assert np.isfinite(found.left_out).all()


def test_where_the_linear_model_misleads_the_simulation_leads_to_its_minimum(data):
    """A loop that answers less than the real one, the other way, and as at another time."""
    start = _start(torque=0.05, factor=0.9)
    along, so_far = along_of(data)
    wrong = [replace(one, torque=one.torque[::-1] * -0.2) for one in along.sections]
    fitted, mask = data.fitted, data.fitted_mask
    misleading = AlongMotion(fitted, wrong, mask, so_far.known, NOISE_RAD)
    simulated = Positions(fitted, mask)
    (led,) = fit_corrected([start], misleading, simulated, data.folds, 2)
    (found,) = fit_corrected([start], misleading, simulated, data.folds, 2, settling=True)
    assert led.rmse > 2 * found.rmse
    assert found.rmse < 1.1 * NOISE_RAD
    theta = start.layout.decode(found.u[None])
    assert theta["coulomb_friction"]["torque"][0, 0] == pytest.approx(0.1, rel=0.05)


def test_a_set_without_terms_is_what_the_model_as_it_came_leaves(data):
    along, so_far = along_of(data)
    simulated = Positions(data.fitted, data.fitted_mask)
    start = Start(Layout(()), np.zeros(0))
    (found,) = fit_corrected([start], along, simulated, data.folds, 2, settling=True)
    assert found.rmse == pytest.approx(so_far.rmse)
