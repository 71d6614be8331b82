"""Learned curves in a model file."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import FRICTION, MOTOR, TENDON, TORQUE, Curve, Law
from t2l.errors import ConfigurationError
from t2l.identify.model import Model, check_joints, read_model, write_model
from tests.diagnose.made import pendulum, predict, recording, swing

ENTRY = {"kind": "torque", "joint": "hinge", "follows": "position", "at": [0, 1], "torque": [0, 1]}


LIMIT = {"kind": "limit", "follows": "velocity", "at": [-1, 1]}


def write(folder, **changes):
    import yaml

    pendulum(folder)
    path = folder / "model.yaml"
    path.write_text(yaml.safe_dump({"robot": "pendulum.xml", "learned": [ENTRY | changes]}))
    return path


def test_a_curve_comes_back_as_it_was_written(tmp_path):
    curves = (
        Curve(Law(TORQUE, "hinge", "velocity", "hinge"), (-1.0, 0.0, 2.0), (0.1, 0.0, -0.25)),
        Curve(Law(MOTOR, "hinge", "supply voltage", "hinge"), (10.0, 12.0), (-0.2, 0.0)),
        Curve(Law(TENDON, "hinge", "position", "knee"), (-1.0, 1.0), (0.5, -0.5), -0.8),
    )
    model = Model(pendulum(tmp_path), learned=curves)
    write_model(model, tmp_path / "model.yaml")
    assert read_model(tmp_path / "model.yaml") == model


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"kind": "magic"}, "kind"),
        # which is an effect, as of a file of an earlier version
        ({"kind": "hysteresis", "follows": "distance"}, "kind: found 'hysteresis'"),
        ({"follows": "moon"}, "follows"),
        ({"kind": "friction", "follows": "velocity"}, "follows"),
        ({"at": [0, 1, 2]}, "3 values"),
        ({"at": [1, 0]}, "increase"),
        ({"at": [0], "torque": [0]}, "1 values"),
        ({"at": [0, 1e-300, 2e-300], "torque": [0, 1, 2]}, "at: found values 1e-300 rad apart"),
        ({"at": [1.7e9, 1.7e9 + 1e-10]}, "increase"),
        (LIMIT | {"torque": [-1, -1]}, "a limit of -1 N·m at -?[01] rad/s, which drives"),
        (LIMIT | {"torque": [-1, 2]}, "a limit of -1 N·m at -1 rad/s"),
        (LIMIT | {"torque": [1, -2]}, "a limit of -0.5 N·m at 0 rad/s"),
        (LIMIT | {"at": [1, 2], "torque": [1, 4]}, "a limit of -2 N·m at 0 rad/s"),
        ({"torque": [0, float("nan")]}, "torque"),
        ({"follows": "time", "of": "other"}, "of"),
        ({"kind": "motor"}, "temperature, supply voltage"),
        ({"follows": "temperature", "of": "other"}, "of"),
        ({"colour": 1}, "colour"),
        ({"ratio": 0.5}, "only for a tendon"),
        ({"kind": "tendon", "ratio": 0.5}, "another joint"),
        ({"kind": "tendon", "of": "other"}, "ratio: found"),
        ({"kind": "tendon", "of": "other", "ratio": 0.0}, "ratio: found"),
        ({"kind": "tendon", "follows": "load", "of": "other"}, "follows"),
    ],
)
def test_a_broken_curve_is_told(tmp_path, changes, key):
    with pytest.raises(ConfigurationError, match=key):
        read_model(write(tmp_path, **changes))


def test_a_curve_of_another_joint_is_told(tmp_path):
    path = write(tmp_path, joint="knee")
    with pytest.raises(ConfigurationError, match="knee"):
        check_joints(path, read_model(path), ("hinge",))


@pytest.mark.parametrize(
    ("x", "torque"), [(3.0, 0.8), (4.0, 1.2), (9.0, 1.2), (-1.0, 0.2), (-2.0, 0.3), (-4.0, 0.3)]
)
def test_a_curve_goes_on_straight_as_far_again_as_it_is_long(x, torque):
    curve = Curve(Law(TORQUE, "hinge", "velocity", "hinge"), (0.0, 1.0, 2.0), (0.1, 0.0, 0.4))
    assert curve(x) == pytest.approx(torque)
    assert np.interp(x, *curve.table()) == pytest.approx(torque)


def test_dry_friction_never_drives():
    curve = Curve(Law("friction", "hinge", "speed", "hinge"), (0.0, 1.0), (0.2, 0.1))
    np.testing.assert_allclose(curve(np.array([1.5, 2.0, 9.0])), [0.05, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("law", "at", "torque", "effects"),
    [
        (Law(TORQUE, "hinge", "constant", "hinge"), [0, 1], [0.05, 0.05],
         {"torque_offset": {"torque": {"hinge": 0.05}}}),
        (Law(TORQUE, "hinge", "velocity", "hinge"), [-20, 20], [0.6, -0.6],
         {"viscous_friction": {"damping": {"hinge": 0.03}}}),
        (Law("friction", "hinge", "constant", "hinge"), [0, 1], [0.05, 0.05],
         {"coulomb_friction": {"torque": {"hinge": 0.05}}}),
    ],
)  # fmt: skip
def test_a_curve_does_what_the_effect_of_its_shape_does(tmp_path, law, at, torque, effects):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), duration_s=0.8)
    curve = Curve(law, tuple(map(float, at)), tuple(map(float, torque)))
    by_curve, by_effect = predict(one, model=Model(robot, learned=(curve,))), predict(one, effects)
    change = np.abs(by_effect - predict(one)).max()
    np.testing.assert_allclose(by_curve, by_effect, atol=0.01 * change)


@pytest.mark.parametrize(
    ("kind", "torque", "effects"),
    [
        (FRICTION, [0.08, 0.05],
         {"friction_temperature": {"torque": {"hinge": 0.08}, "per_kelvin": {"hinge": -1.5e-3}}}),
        (MOTOR, [-0.1, -0.19],
         {"torque_constant_temperature": {
             "factor": {"hinge": 0.9}, "per_kelvin": {"hinge": -5e-3}}}),
    ],
)  # fmt: skip
def test_a_curve_over_temperature_does_what_its_effect_does(tmp_path, kind, torque, effects):
    robot = pendulum(tmp_path)
    one = recording(robot, swing(), duration_s=0.8)
    one = replace(one, temperature=25 + 20 * one.time[:, None])
    curve = Curve(Law(kind, "hinge", "temperature", "hinge"), (25.0, 45.0), tuple(torque))
    by_curve, by_effect = predict(one, model=Model(robot, learned=(curve,))), predict(one, effects)
    change = np.abs(by_effect - predict(one)).max()
    assert change > 1e-3
    np.testing.assert_allclose(by_curve, by_effect, atol=1e-4 * change)


@pytest.mark.parametrize("begin_s", [0.0, 40.0])
def test_a_curve_over_a_phase_does_what_a_periodic_torque_does(tmp_path, begin_s):
    """It begins anew after each period, also before and beyond the clocks that it was drawn at."""
    robot, frequency = pendulum(tmp_path), 2.5
    one = recording(robot, swing(), duration_s=0.8)
    one = replace(one, time=one.time + 7.3)
    at = begin_s + np.linspace(0, 1 / frequency, 101)
    curve = Curve(
        Law(TORQUE, "hinge", "phase", "hinge"),
        tuple(at), tuple(0.05 * np.sin(2 * np.pi * frequency * at + 0.4)),
    )  # fmt: skip
    values = {"amplitude": 0.05, "frequency": frequency, "phase": 0.4}
    effects = {"periodic_torque": {name: {"hinge": value} for name, value in values.items()}}
    by_curve, by_effect = predict(one, model=Model(robot, learned=(curve,))), predict(one, effects)
    change = np.abs(by_effect - predict(one)).max()
    np.testing.assert_allclose(by_curve, by_effect, atol=2e-3 * change)


@pytest.mark.parametrize("follows", ["phase", "session time"])
def test_a_curve_over_a_clock_that_counts_from_1970_is_read_as_it_was_written(tmp_path, follows):
    at = tuple(1.7e9 + np.linspace(0, 2.5, 31))
    curve = Curve(Law(TORQUE, "hinge", follows, "hinge"), at, tuple(np.linspace(0, 0.1, 31)))
    model = Model(pendulum(tmp_path), learned=(curve,))
    write_model(model, tmp_path / "model.yaml")
    (read,) = read_model(tmp_path / "model.yaml").learned
    np.testing.assert_allclose(np.subtract(read.at, at), 0, atol=1e-5)


def test_a_motor_may_brake_beyond_its_fastest(tmp_path):
    path = write(tmp_path, **LIMIT | {"at": [-5, 0, 10], "torque": [3, 2, -2]})
    (curve,) = read_model(path).learned
    assert curve.torque == (3.0, 2.0, -2.0)
