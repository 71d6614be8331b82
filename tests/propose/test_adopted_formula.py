"""A formula in a model moves the robot, is written and read, and is exported as it acts."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.formula import FormulaTorque
from t2l.effects.law import ALLOWED, COLUMNS, FRICTION, GIVEN, MOTOR, TORQUE, UNITS, Curve, Law
from t2l.export.folder import write_export
from t2l.export.mjcf import Controller
from t2l.identify.model import Model
from t2l.propose.artefacts import formula_law, with_formula
from t2l.propose.expression import Formula
from tests.diagnose.made import measured, pendulum, predict, recording, swing
from tests.export.test_export import exported

FOLLOWED = [
    (kind, follows)
    for kind in (TORQUE, FRICTION)
    for follows in ALLOWED[kind]
    if follows not in GIVEN
]
LOGGED = [(kind, follows) for kind in (TORQUE, FRICTION, MOTOR) for follows in COLUMNS]


@pytest.mark.parametrize(("kind", "follows"), FOLLOWED)
def test_an_exported_formula_moves_the_robot_as_ours(tmp_path, kind, follows):
    robot, law = pendulum(tmp_path), Law(kind, "hinge", follows, "hinge")
    values = {"a": 0.03, "b": 0.02}
    units = {"a": "N·m", "b": f"N·m/({UNITS[follows]})"}
    formula = formula_law(law, Formula("a + b * x", values, units))
    model = with_formula(Model(robot), formula, values)
    content, error, log = exported(
        tmp_path / "out", robot, model.effects, formulas=model.formulas
    )  # fmt: skip
    assert not content["not_carried"]
    plain = measured(log).q
    moved = np.sqrt(np.mean((measured(log, model=model).q - plain) ** 2))
    assert moved > 1e-3
    assert error < max(0.01 * moved, 3e-5)


@pytest.mark.parametrize(("kind", "follows"), [(TORQUE, "position"), (FRICTION, "speed")])
def test_so_does_an_exported_curve(tmp_path, kind, follows):
    robot, law = pendulum(tmp_path), Law(kind, "hinge", follows, "hinge")
    at = np.linspace(-3.0, 3.0, 40)
    learned = (Curve(law, tuple(at), tuple(0.03 + 0.02 * at)),)
    _, error, log = exported(tmp_path / "out", robot, {}, learned=learned)
    moved = measured(log, model=Model(robot, learned=learned)).q - measured(log).q
    assert error < max(0.01 * np.sqrt(np.mean(moved**2)), 3e-5)


@pytest.mark.parametrize(("kind", "follows"), LOGGED)
def test_what_follows_a_column_moves_as_its_curve_and_is_not_exported(tmp_path, kind, follows):
    robot, law = pendulum(tmp_path), Law(kind, "hinge", follows, "hinge")
    values = {"a": 0.01, "b": 0.005}
    formula = formula_law(law, Formula("a + b * x", values, dict.fromkeys(values, "")))
    effect = FormulaTorque(formula)
    learned = (Curve(law, (5.0, 25.0), (0.035, 0.135)),)

    bare = recording(robot, swing())
    assert not effect.may_act([bare])
    one = replace(bare, **{COLUMNS[follows]: 8.0 + 10 * bare.time[:, None]})
    assert effect.may_act([one])
    models = with_formula(Model(robot), formula, values), Model(robot, learned=learned)
    by_formula, by_curve = (predict(one, model=model) for model in models)
    assert np.abs(by_formula - predict(one)).max() > 1e-3
    np.testing.assert_allclose(by_formula, by_curve, atol=1e-6)

    controller = Controller(one.joints, one.kp, one.kd, one.control_rate_hz, False)
    for model in models:
        (tmp_path / "out").mkdir(exist_ok=True)
        vector = model.vector(one.joints)
        content = write_export(model, controller, *vector, None, tmp_path / "out")
        assert list(content["not_carried"].values()) == [f"a simulator has no {follows}"]
