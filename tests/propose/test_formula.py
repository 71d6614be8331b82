"""Formulas for planted curves, their units, and the effects they become."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from t2l.effects.law import FRICTION, MOTOR, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.propose.artefacts import formula_law, with_formula
from t2l.propose.cross_validation import left_out
from t2l.propose.expression import Formula, read, written
from t2l.propose.formula import Fitted, candidates, chosen, promising
from t2l.propose.proposal import Learned
from tests.diagnose.made import pendulum, predict, recording, swing

pytest.importorskip("pyoperon")

X = np.linspace(-0.5, 1.1, 40)


def learned(values, follows="position", kind=TORQUE, part=0.03):
    half = part * np.abs(values).max()
    noise = 0.3 * half * np.random.default_rng(0).normal(size=len(values))
    law = Law(kind, "hinge", follows, "hinge")
    curve = Curve(law, tuple(X.tolist()), tuple((values + noise).tolist()))
    return Learned(curve, values + noise - half, values + noise + half)


def formula(one, judge=None):
    """The one that is chosen; without a judge the shortest within the band."""
    offered = candidates(one)
    if judge is None:
        return next(offered, None)
    return chosen(promising([*offered], judge), judge)


def found(*arguments, **others):
    return formula(learned(*arguments, **others))


def test_a_sine_is_found_with_its_units():
    formula = found(0.05 * np.sin(9 * X + 0.3))
    assert "sin" in formula.text
    np.testing.assert_allclose(formula(X), 0.05 * np.sin(9 * X + 0.3), atol=1.5e-3)
    assert "1/rad" in formula.units.values()
    assert len(formula.values) <= 4


@pytest.mark.parametrize("level", [0.0, 0.02])
def test_a_ripple_of_many_turns_is_found(level):
    """A search over formulas hardly finds its frequency."""
    formula = found(0.05 * np.sin(45 * X + 0.3) + level, part=0.1)
    turn = next(value for name, value in formula.values.items() if formula.units[name] == "1/rad")
    assert turn == pytest.approx(45, rel=0.01)
    np.testing.assert_allclose(formula(X), 0.05 * np.sin(45 * X + 0.3) + level, atol=2.5e-3)


def test_a_square_with_sign_is_found_over_velocity():
    formula = found(-0.02 * X * np.abs(X), "velocity", part=0.01)
    assert formula.text == "a * x * abs(x)"
    assert formula.values["a"] == pytest.approx(-0.02, rel=0.03)
    assert formula.units == {"a": "N·m/(rad/s)²"}


@pytest.mark.parametrize(
    ("values", "text"), [(0 * X + 0.3, "a"), (-0.2 * X, "a * x"), (0.1 - 0.2 * X, "a * x + b")]
)
def test_the_shortest_comes_first(values, text):
    assert found(values).text == text


def test_a_share_has_no_newton_metres():
    assert found(0.1 - 0.2 * X, "temperature", MOTOR).units == {"a": "1/°C", "b": ""}


@pytest.mark.parametrize("begin", [0.0, 7.0, 1.7e9])
def test_what_repeats_gets_a_sine_of_the_clock_with_the_period_of_its_curve(begin):
    """Which the formula keeps beyond the curve, where its clock goes on."""
    from t2l.propose.formula import extent

    period, turn = 0.8, np.linspace(0, 2 * np.pi, 40)
    law = Law(TORQUE, "hinge", "phase", "hinge")
    at, values = begin + turn * period / (2 * np.pi), 0.05 * np.sin(turn + 0.3)
    curve = Curve(law, tuple(at), tuple(values))
    shown = Learned(curve, values - 1e-3, values + 1e-3)
    one = formula(shown)
    assert one.text == "c * sin(a * x + b)"
    assert extent(one, shown) == pytest.approx((begin, begin + period), abs=1e-3)
    np.testing.assert_allclose(one(at + 5 * period), values, atol=2e-3)
    saw = np.linspace(-1, 1, 40)
    assert formula(Learned(Curve(law, tuple(at), tuple(saw)), saw - 0.01, saw + 0.01)) is None


def test_what_no_short_formula_fits_has_none():
    rough = np.random.default_rng(3).normal(size=len(X))
    assert found(rough, part=0.01) is None


class Elsewhere:
    """Judges formulas, and fits them, where another curve goes on and is measured with noise."""

    def __init__(self, truth, limit=np.inf, noise=0.0):
        self.x, self.limit = np.linspace(-0.5, 4.0, 120), limit
        self.y = truth(self.x) + noise * np.random.default_rng(0).normal(size=120)
        self.block = np.arange(120) // 5

    def errors(self, formulas):
        return [float(np.sqrt(np.mean((one(self.x) - self.y) ** 2))) for one in formulas]

    def fitted(self, formula):
        names, start = list(formula.values), list(formula.values.values())

        def left(values):
            return formula(self.x, dict(zip(names, values, strict=True))) - self.y

        best = least_squares(left, start, x_scale=np.abs(start) + 1e-9)
        one = replace(formula, values=dict(zip(names, best.x.tolist(), strict=True)))
        return Fitted(one, *self.errors([one]), left_out(best.jac, best.fun, self.block))


def test_of_formulas_within_the_band_the_one_that_holds_beyond_it_is_taken():
    """A straight line is shorter, and as near as the band is wide, but not where others look."""
    one, judge = learned(np.exp(-X), "session time", part=0.2), Elsewhere(lambda x: np.exp(-x))
    assert formula(one).text == "a * x + b"
    taken = formula(one, judge)
    assert "exp" in taken.text
    assert judge.errors([taken])[0] < 0.1 * judge.errors([formula(one)])[0]


def test_the_shortest_formula_is_taken_of_which_no_other_foretells_more():
    def slow(x):
        return 0.3 + 0.7 * np.exp(-0.5 * x)

    one, exact = learned(slow(X), "session time", part=0.1), Elsewhere(slow)
    taken, rough = (formula(one, judge) for judge in (exact, Elsewhere(slow, noise=0.4)))
    assert exact.errors([taken])[0] <= 1e-3 < exact.errors([rough])[0] <= 0.2
    assert len(rough.values) < len(taken.values)
    # a difference of a hundredth of the error is told where chance does not explain it
    assert exact.errors([formula(one, Elsewhere(slow, noise=0.02))])[0] <= 0.01


@pytest.mark.parametrize(("level", "text"), [(0.0, ""), (0.3, " + c")])
@pytest.mark.parametrize("rate", [1.0, 3.0])
def test_what_comes_to_rest_over_time_is_offered_as_a_decay(rate, level, text):
    """A search may miss it, where the curve is short."""
    one = learned(level + 0.7 * np.exp(-rate * X), "session time", part=0.02)
    found = [each for each in candidates(one) if each.text == f"b * exp(a * x){text}"]
    assert found[0].values["a"] == pytest.approx(-rate, rel=0.25)
    # each is offered once
    assert len(found) == 1


@pytest.mark.parametrize(("gain", "taken"), [(0.002, 0), (0.02, 1)])
def test_a_difference_that_is_sure_but_none_to_speak_of_does_not_count(gain, taken):
    both = [Formula("a", {"a": 1.0}, {"a": ""}), Formula("a * x", {"a": 1.0}, {"a": ""})]

    left = [np.ones(120), np.ones(120) * (1 - gain)]
    fitted = [Fitted(one, 1.0, each) for one, each in zip(both, left, strict=True)]
    judge = Elsewhere(lambda x: x)
    assert chosen(fitted, judge) is both[taken]


def test_what_leaves_more_than_may_be_left_is_none():
    one = learned(np.exp(-X), "session time", part=0.2)
    assert formula(one, Elsewhere(lambda x: np.sin(20 * x), limit=0.1)) is None


@pytest.mark.parametrize(
    ("text", "expected", "units"),
    [
        ("((2.0 * X1) * (3.0 * X2))", "a * x * abs(x)", {"a": "N·m/rad²"}),
        ("(1.0 + ((-2.0) * sin((3.0 * X1))))", "b * sin(a * x) + c",
         {"a": "1/rad", "b": "N·m", "c": "N·m"}),
        ("((2.0 * X1) + (3.0 * X1))", "a * x", {"a": "N·m/rad"}),
        ("((2.0 * X1) ^ 2)", "a * x**2", {"a": "N·m/rad²"}),
        ("exp((X1 + 0.5))", "c * exp(a * x + b)", {"a": "1/rad", "b": "", "c": "N·m"}),
    ],
)  # fmt: skip
def test_trees_are_folded_and_get_units(text, expected, units):
    formula = written(read(text), "rad")
    assert formula.text == expected
    assert formula.units == units


@pytest.mark.parametrize("text", ["__import__('os')", "X1 / X2", "X3", "cos(X1)"])
def test_other_text_is_refused(text):
    with pytest.raises(ValueError, match="found no formula"):
        read(text)


@pytest.mark.parametrize(
    ("kind", "follows", "text"),
    [
        (TORQUE, "position", "(0.5 + ((-0.4) * X1))"),
        (TORQUE, "commanded torque", "((-0.1) * X1)"),
        (FRICTION, "speed", "(0.02 + (0.01 * X1))"),
    ],
)
def test_a_formula_does_what_the_curve_does(tmp_path, kind, follows, text):
    robot, law = pendulum(tmp_path), Law(kind, "hinge", follows, "hinge")
    formula = written(read(text), law.unit)
    model = with_formula(Model(robot), formula_law(law, formula), formula.values)
    at = np.linspace(0.0 if kind == FRICTION else -30.0, 30.0, 61)
    one = recording(robot, swing(), duration_s=0.6)
    by_formula = predict(one, model=model)
    curve = Curve(law, tuple(at.tolist()), tuple(formula(at).tolist()))
    by_curve = predict(one, model=Model(robot, learned=(curve,)))
    np.testing.assert_allclose(by_formula, by_curve, atol=2e-6)
    assert np.abs(by_formula - predict(one)).max() > 1e-4
