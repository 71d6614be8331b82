"""A formula as an effect: the file can be loaded, moves the robot, and is exported as it acts."""

import numpy as np
import pytest

from t2l.effects.law import ALLOWED, FRICTION, TORQUE, UNITS, Curve, Law
from t2l.effects.registry import load
from t2l.identify.model import Model
from t2l.propose.effect_file import effect_name, effect_text
from t2l.propose.expression import Formula
from tests.diagnose.made import measured, pendulum
from tests.export.test_export import exported

FOLLOWED = [(kind, follows) for kind in (TORQUE, FRICTION) for follows in ALLOWED[kind]]


@pytest.mark.parametrize(("kind", "follows"), FOLLOWED)
def test_an_exported_formula_moves_the_robot_as_ours(tmp_path, kind, follows):
    robot, law = pendulum(tmp_path), Law(kind, "hinge", follows, "hinge")
    values = {"a": 0.03, "b": 0.02}
    units = {"a": "N·m", "b": f"N·m/({UNITS[follows]})"}
    path = tmp_path / "own.py"
    path.write_text(effect_text(law, Formula("a + b * x", values, units)))
    name = effect_name(law)
    assert set(load([path])) >= {name}
    effects = {name: {key: {"hinge": value} for key, value in values.items()}}
    content, error, log = exported(tmp_path / "out", robot, effects, files=(path,))
    assert not content["not_carried"]
    plain = measured(log).q
    moved = np.sqrt(np.mean((measured(log, model=Model(robot, effects, (path,))).q - plain) ** 2))
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
