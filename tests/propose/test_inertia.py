"""A missing inertia is a straight line over the acceleration, simulated as what it is."""

import numpy as np
import pytest

from t2l.effects.law import INERTIA, Curve, Law
from t2l.errors import ConfigurationError
from t2l.identify.curves import CurveEntry, read_curves
from t2l.identify.model import Model
from t2l.propose.proposal import LAW
from tests.diagnose.made import ARMATURE, pendulum, predict, recording, swing
from tests.export.test_export import exported
from tests.propose.made import learn, machine

LIGHT = 0.004  # kg·m²
LIGHTER = -2 * ARMATURE
OVER_ACCELERATION = Law(INERTIA, "hinge", "acceleration", "hinge")


def line(inertia):
    return Curve(OVER_ACCELERATION, (-50.0, 50.0), (50.0 * inertia, -50.0 * inertia))


def test_a_line_over_the_acceleration_is_an_armature(tmp_path):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), duration_s=0.6)
    as_armature = predict(one, {"armature": {"inertia": {"hinge": LIGHT}}})
    as_line = predict(one, model=Model(robot, learned=(line(LIGHT),)))
    np.testing.assert_array_equal(as_line, as_armature)
    assert np.abs(as_line - predict(one)).max() > 1e-4


def test_a_missing_inertia_is_recovered(tmp_path):
    robot = pendulum(tmp_path)
    found = learn(robot, machine(robot, [line(LIGHT)]))
    assert found.verdict == LAW
    (one,) = found.learned
    assert one.curve.law == OVER_ACCELERATION
    assert one.curve.inertia == pytest.approx(LIGHT, rel=0.05)
    assert found.choice_rmse_rad < 1.2 * found.noise_floor_rad


def test_a_lighter_link_takes_away_more_than_the_armature(tmp_path):
    robot = pendulum(tmp_path)
    found = learn(robot, machine(robot, [line(LIGHTER)]))
    (one,) = found.learned
    assert one.curve.inertia == pytest.approx(LIGHTER, rel=0.05)
    assert found.choice_rmse_rad < 1.2 * found.noise_floor_rad


def test_an_armature_beside_a_lighter_link_takes_nothing_back(tmp_path):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), duration_s=0.6)
    none = {"armature": {"inertia": {"hinge": 0.0}}}
    beside = predict(one, model=Model(robot, effects=none, learned=(line(LIGHTER),)))
    np.testing.assert_array_equal(
        beside, predict(one, model=Model(robot, learned=(line(LIGHTER),)))
    )


def test_some_inertia_is_always_left(tmp_path):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), duration_s=0.6)
    q = [predict(one, model=Model(robot, learned=(line(kg_m2),))) for kg_m2 in (-10.0, -20.0)]
    assert np.isfinite(q).all()
    np.testing.assert_array_equal(*q)


@pytest.mark.parametrize("inertia", [LIGHT, LIGHTER])
def test_an_exported_robot_has_it_as_armature(tmp_path, inertia):
    robot = pendulum(tmp_path)
    bare = exported(tmp_path / "bare", robot, {})[1]
    content, error, _ = exported(tmp_path / "out", robot, {}, learned=(line(inertia),))
    assert content["in_mjcf"] == [OVER_ACCELERATION.name]
    # MuJoCo's own step is of lower order than ours
    assert error < bare + 1e-6


def test_an_inertia_that_is_no_straight_line_is_refused():
    entry = CurveEntry(
        kind="inertia", joint="hinge", follows="acceleration", at=(-1, 0, 1), torque=(1, 0, -2)
    )
    with pytest.raises(ConfigurationError, match="found 3 values of an inertia; allowed: the 2"):
        read_curves([entry])
