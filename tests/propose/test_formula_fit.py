"""Constants of formulas are recovered through the simulation, beyond the curve too."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import PHASE, TORQUE, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.expression import Formula
from t2l.propose.formula_fit import FAR, Simulation, formulas_of, together
from t2l.propose.laws import seen
from t2l.propose.proposal import LAW as FOUND
from t2l.propose.proposal import Learned, Proposal
from tests.diagnose.made import pendulum
from tests.propose.made import POSITIONS, machine, planted

LAW = Law(TORQUE, "hinge", "position", "hinge")
NOISE_RAD = 1e-4


def simulation(robot, shape, reach=(-0.3, 0.3)):
    """Of recordings with a torque over position, of which a curve shows a part."""
    predictor = Predictor(robot, machine(robot, [planted(LAW, POSITIONS, shape(POSITIONS))], 3))
    at = np.linspace(*reach, 9)
    every = [(predictor, np.ones(len(predictor.samples), bool))]
    curve = planted(LAW, at, 1.1 * shape(at))
    torque = np.array(curve.torque)
    return Simulation(Learned(curve, torque, torque), Model(robot), every, np.inf)


def ripple(**values):
    return Formula("a * sin(b * x) + c", values, {"a": "N·m", "b": "1/rad", "c": "N·m"})


def test_constants_are_recovered_that_fit_the_curve_less_well(tmp_path):
    truth = {"a": 0.05, "b": 3.0, "c": 0.02}
    judge = simulation(pendulum(tmp_path), ripple(**truth))
    begun = ripple(a=0.055, b=2.7, c=0.001)
    fitted = judge.fitted(begun).formula
    assert fitted.values == pytest.approx(truth, rel=0.03)
    before, after = judge.errors([begun, fitted])
    assert after < 1.1 * NOISE_RAD < 3 * NOISE_RAD < before


def test_a_formula_is_simulated_as_far_as_the_recordings_go(tmp_path):
    """Further than a curve says anything, from recordings that others go beyond."""
    shape = ripple(a=0.05, b=5.0, c=0.0)
    judge = simulation(pendulum(tmp_path), shape, reach=(-0.05, 0.05))
    assert judge.errors([shape])[0] > 10 * NOISE_RAD
    predictors = [predictor for predictor, _ in judge.sets]
    far = replace(judge, one=replace(judge.one, seen=seen(predictors)[LAW]))
    assert far.errors([shape])[0] < 1.1 * NOISE_RAD


def test_a_fit_goes_on_until_it_settles(tmp_path):
    """Where constants do much the same a fit is slow, and not yet worse than another formula."""
    truth = {"a": -3.0, "b": 0.03, "c": 0.03}
    units = {"a": "1/rad", "b": "N·m", "c": "N·m"}
    decay = Formula("b * exp(a * x) + c", {"a": -0.3, "b": 0.1, "c": -0.04}, units)
    shape = Formula(decay.text, truth, units)
    fitted = simulation(pendulum(tmp_path), shape).fitted(decay).formula
    assert fitted.values == pytest.approx(truth, rel=0.03)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a * exp(b * x)", {"a": 1.0, "b": 1e5}),
        ("a * tanh(b * x)", {"a": 1e307, "b": 1e3}),  # only the slope is infinite
    ],
)
def test_a_formula_that_runs_away_is_far_and_does_not_hide_the_others(tmp_path, text, values):
    judge = simulation(pendulum(tmp_path), lambda x: 0.05 * x)
    line = {"text": "a * x", "units": {"a": "N·m/rad"}}
    wild = Formula(text, values, {"a": "N·m", "b": "1/rad"})
    errors = judge.errors([wild, Formula(values={"a": 0.05}, **line)])
    assert errors[0] == FAR
    assert errors[1] < 1.1 * NOISE_RAD
    assert judge.errors([judge.fitted(wild).formula])[0] == FAR


def test_constants_of_two_formulas_fit_beside_each_other(tmp_path):
    """Beside the other's curve, which is off, each would stay off to make up for it."""
    robot, speeds = pendulum(tmp_path), np.linspace(-20.0, 20.0, 40)
    velocity = Law(TORQUE, "hinge", "velocity", "hinge")
    truth = {LAW: -0.2, velocity: -0.02}
    ranges = {LAW: POSITIONS, velocity: speeds}
    made = machine(robot, [planted(law, at, truth[law] * at) for law, at in ranges.items()], 3)
    predictor = Predictor(robot, made)
    off = {law: planted(law, at, 0.8 * truth[law] * at) for law, at in ranges.items()}
    learned = tuple(Learned(curve, curve.torque, curve.torque) for curve in off.values())
    errors = (NOISE_RAD, 1e-2, 1e-3, None, None)
    proposal = Proposal(FOUND, Model(robot), ("hinge",), learned, *errors, (), (), ())
    begun = {law: Formula("a * x", {"a": 0.8 * a}, {"a": ""}) for law, a in truth.items()}
    every = [(predictor, np.ones(len(predictor.samples), bool))]
    found = together(proposal, begun, every)
    for law, a in truth.items():
        assert found[law].values["a"] == pytest.approx(a, rel=0.02)


def test_a_formula_is_chosen_beside_the_formulas_of_other_laws(tmp_path):
    """A line needs no constant but to undo that of the other law's curve."""
    pytest.importorskip("pyoperon")
    robot, shift = pendulum(tmp_path), 3e-4
    phase = np.linspace(0.0, 0.4, 60)
    wave, line = 0.1 * np.sin(2 * np.pi * phase / 0.4), -0.2 * POSITIONS
    repeats = Law(TORQUE, "hinge", PHASE, "hinge")

    def curves(shift):
        return planted(LAW, POSITIONS, line + shift), planted(repeats, phase, wave - shift)

    predictor = Predictor(robot, machine(robot, curves(0.0), 3))
    off = [(curve, np.array(curve.torque)) for curve in curves(shift)]
    learned = tuple(Learned(curve, y - 2 * shift, y + 2 * shift) for curve, y in off)
    errors = (NOISE_RAD, 1e-2, NOISE_RAD, None, None)
    proposal = Proposal(FOUND, Model(robot), ("hinge",), learned, *errors, (), (), ())
    found = formulas_of(proposal, [(predictor, np.ones(len(predictor.samples), bool))])
    assert found[LAW].text == "a * x"
    assert found[LAW].values["a"] == pytest.approx(-0.2, rel=0.01)
    assert found[repeats].text == "c * sin(a * x + b)"
