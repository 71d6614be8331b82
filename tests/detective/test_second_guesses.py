"""A ripple that was read off while friction was missing too is read off anew beside it."""

import numpy as np
import pytest

from t2l.detective.along_motion import fit_along
from t2l.detective.data_split import split
from t2l.detective.fitted_set import Start
from t2l.detective.pruning import without_one, worth_a_fit
from t2l.detective.second_guesses import second_guesses
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from tests.detective.test_along_motion import NOISE_RAD, along_of
from tests.diagnose.made import pendulum, swings

HIDDEN = {
    "cogging": {"amplitude": {"hinge": 0.1}, "phase": {"hinge": 0.5}, "periods": {"hinge": 23.0}},
    "coulomb_friction": {"torque": {"hinge": 0.1}},
}
# in a minimum of its own, far from the truth
WRONG = {
    "cogging": {
        "amplitude": np.array([0.02]),
        "phase": np.array([0.0]),
        "periods": np.array([9.0]),
    },
    "coulomb_friction": {"torque": np.array([0.08])},
}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    return split(
        robot, swings(robot, HIDDEN, NOISE_RAD, duration_s=2.0), swings(robot)[:1], threads=1
    )


@pytest.fixture(scope="module")
def along(data):
    return along_of(data)[0]


def fitted(data, along, values):
    layout = Layout([Term(builtin()[name], (0,)) for name in values])
    (found,) = fit_along([Start(layout, layout.encode(values))], along, data.folds)
    return found


def test_a_wrong_minimum_of_a_ripple_is_left_beside_the_rest(data, along):
    lost = fitted(data, along, WRONG)
    best = min(second_guesses(lost, along, data.folds), key=lambda one: one.rmse)
    theta = best.layout.decode(best.u[None])
    assert theta["cogging"]["periods"][0, 0] == pytest.approx(23.0, rel=0.01)
    assert best.names == lost.names
    # along the motion, not by simulation, of a loop that lacks both
    assert best.rmse < 0.1 * lost.rmse


def test_what_derivatives_say_is_missed_is_not_fitted_and_what_is_not_missed_is(data, along):
    """Of friction, ripple and an offset that is zero only the last may go."""
    values = {
        name: {key: np.array([value["hinge"]]) for key, value in numbers.items()}
        for name, numbers in HIDDEN.items()
    }
    whole = fitted(data, along, {**values, "torque_offset": {"torque": np.array([0.0])}})
    some = worth_a_fit(whole, without_one(whole), along)
    assert [{term.effect.name for term in one.layout.terms} for one in some] == [set(HIDDEN)]
