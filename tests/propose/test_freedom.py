"""How many numbers names spend, and how many curves need."""

import numpy as np
import pytest

from t2l.effects.law import TORQUE, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.bases import effect_of, straight
from t2l.propose.expression import Formula
from t2l.propose.found import Search
from t2l.propose.freedom import freedom, independent
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, with_law
from t2l.propose.search import search
from t2l.propose.split import split
from tests.diagnose.made import pendulum
from tests.propose.test_search import POSITIONS, machine, planted

LINK = {
    "mass_factor": {"hinge": 1.2}, "com_x": {"hinge": 0.01}, "com_y": {"hinge": 0.01},
    "com_z": {"hinge": 0.01}, "inertia_factor": {"hinge": 1.1},
}  # fmt: skip
SPRING = {"stiffness": {"hinge": 0.1}, "rest": {"hinge": 0.5}}


def samples_of(robot, curves=()):
    predictor = Predictor(robot, machine(robot, curves, 3), threads=1)
    return LearningSamples(predictor, *split(predictor))


@pytest.mark.parametrize(
    ("effects", "numbers"), [({"link_inertia": LINK}, 3), ({"parallel_spring": SPRING}, 2)]
)
def test_numbers_count_as_far_as_recordings_tell_them_apart(tmp_path, effects, numbers):
    """A pendulum shows two moments of a link's mass, and its inertia."""
    robot = pendulum(tmp_path)
    samples = samples_of(robot)
    state = State(*Model(robot, effects).vector(("hinge",)))
    assert independent(state, state.layout.slots, samples) == numbers


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    [(lambda q: 0.1 - 0.1 * q, 2.0, 2.0), (lambda q: 0.1 * np.sin(3 * q), 3.0, 8.0)],
)
def test_a_straight_line_needs_two_numbers_and_a_wave_more(tmp_path, shape, low, high):
    robot = pendulum(tmp_path)
    law = Law(TORQUE, "hinge", "position", "hinge")
    samples = samples_of(robot, [planted(law, POSITIONS, shape(POSITIONS))])
    found = search(Model(robot), samples)
    assert [effect.law for effect in found.laws] == [law]
    assert low <= freedom(found, samples) <= high


def test_a_constant_that_two_straight_lines_share_counts_once(tmp_path):
    robot, joints = pendulum(tmp_path), ("hinge",)
    samples, state = samples_of(robot), State(*Model(robot).vector(joints))
    for follows, ends in (("position", (-2.0, 2.0)), ("velocity", (-30.0, 30.0))):
        line = straight(effect_of(Law(TORQUE, "hinge", follows, "hinge"), ends, 0.5))
        state = with_law(state, line, np.array([0.1, 0.05]), 1.0, joints)
    (residual,), (error,) = samples.left_by([state])
    found = Search(state, error, error, error, residual)
    assert freedom(found, samples) == pytest.approx(3.0, abs=0.01)


def test_a_curve_that_has_a_formula_counts_as_the_constants_of_it(tmp_path):
    robot = pendulum(tmp_path)
    law = Law(TORQUE, "hinge", "position", "hinge")
    wave = planted(law, POSITIONS, 0.1 * np.sin(3 * POSITIONS + 0.4))
    samples = samples_of(robot, [wave])
    found = search(Model(robot), samples)
    units = {"a": "1/rad", "b": "", "c": "N·m"}
    formula = Formula("c * sin(a * x + b)", {"a": 3.0, "b": 0.4, "c": 0.1}, units)
    assert freedom(found, samples) > 3.5
    assert freedom(found, samples, {law: formula}) == pytest.approx(3.0, abs=0.05)
