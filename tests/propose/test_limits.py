"""A motor's limit over its velocity is found, though it does nothing while it is not reached."""

import numpy as np
import pytest

from t2l.effects.law import LIMIT, Curve, Law
from t2l.identify.model import Model
from t2l.propose.artefacts import formula_law, with_formula
from t2l.propose.expression import Formula
from t2l.propose.proposal import LAW, NOTHING
from tests.diagnose.made import pendulum, predict, recording, swing
from tests.export.test_export import exported
from tests.propose.made import learn, machine

OVER_VELOCITY = Law(LIMIT, "hinge", "velocity", "hinge")
FASTEST = 40.0  # rad/s, of the curve


def limit(stall, no_load):
    ends = np.array([-FASTEST, FASTEST])
    return Curve(OVER_VELOCITY, tuple(ends), tuple(stall * (1 - ends / no_load)))


def test_a_line_over_the_velocity_is_the_torque_speed_limit(tmp_path):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), kp=60.0, kd=0.5)
    known = {"stall_torque": {"hinge": 0.6}, "no_load_speed": {"hinge": 6.0}}
    as_known = predict(one, {"torque_speed_limit": known})
    as_line = predict(one, model=Model(robot, learned=(limit(0.6, 6.0),)))
    np.testing.assert_allclose(as_line, as_known, atol=1e-9)
    assert np.abs(as_line - predict(one)).max() > 1e-2


def test_a_limit_is_recovered(tmp_path):
    robot = pendulum(tmp_path)
    found = learn(robot, machine(robot, [limit(0.6, 6.0)], 3))
    assert found.verdict == LAW
    (one,) = found.learned
    assert one.curve.law == OVER_VELOCITY
    slope, stall = np.polyfit(one.curve.at, one.curve.torque, 1)
    assert stall == pytest.approx(0.6, rel=0.05)
    assert slope == pytest.approx(-0.1, rel=0.1)
    assert found.choice_rmse_rad < 1.2 * found.noise_floor_rad


def test_a_limit_that_is_never_reached_is_not_proposed(tmp_path):
    robot = pendulum(tmp_path)
    assert learn(robot, machine(robot, [limit(100.0, 100.0)])).verdict == NOTHING


def test_its_formula_and_its_export_move_the_robot_as_the_curve_does(tmp_path):
    robot = pendulum(tmp_path)
    values = {"a": 0.6, "b": -0.1}
    units = {"a": "N·m", "b": "N·m/(rad/s)"}
    formula = formula_law(OVER_VELOCITY, Formula("a + b * x", values, units))
    spoken = with_formula(Model(robot), formula, values)
    learned = (limit(0.6, 6.0),)
    one = recording(robot, swing(), kp=60.0, kd=0.5)
    by_formula = predict(one, model=spoken)
    by_curve = predict(one, model=Model(robot, learned=learned))
    np.testing.assert_allclose(by_formula, by_curve, atol=1e-9)
    for model in (spoken, Model(robot, learned=learned)):
        content, error, log = exported(
            tmp_path / "out", robot, model.effects, learned=model.learned, formulas=model.formulas
        )  # fmt: skip
        moved = np.sqrt(np.mean((predict(log, model=model) - predict(log)) ** 2))
        assert not content["not_carried"]
        assert moved > 1e-3
        assert error < max(0.01 * moved, 3e-5)
