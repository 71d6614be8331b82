"""The picture of learned curves shows what is hidden, asked of the generator."""

import numpy as np
import pytest
from benchmarks.hidden_effects import effects as fx
from benchmarks.hidden_effects import real_effects as rx
from benchmarks.hidden_effects.cases import ARM, Case
from benchmarks.learned_curves import draw, hidden_torque

from t2l.effects.law import FRICTION, MOTOR, TORQUE

X = np.array([-2.0, 0.5, 3.0])


def curve(kind, follows):
    return {"kind": kind, "joint": "elbow", "of": "elbow", "follows": follows}


@pytest.mark.parametrize(
    ("effect", "kind", "follows", "torque"),
    [
        (fx.ViscousFriction({"elbow": 0.1}), TORQUE, "velocity", -0.1 * X),
        (fx.QuadraticFriction({"elbow": 0.1}), FRICTION, "speed", 0.1 * X * np.abs(X)),
        (fx.CoulombFriction({"elbow": 0.1}), FRICTION, "constant", 0.1 + 0 * X),
        (rx.DirectionalFriction({"elbow": 0.3}, {"elbow": 0.1}), FRICTION, "constant", 0.2 + 0 * X),
        (rx.DirectionalFriction({"elbow": 0.3}, {"elbow": 0.1}), TORQUE, "constant", -0.1 + 0 * X),
        (rx.ParallelSpring({"elbow": 2.0}, 0.5), TORQUE, "position", 1.0 - 2.0 * X),
        (fx.CoulombFriction({"elbow": 0.1}), TORQUE, "velocity", -0.1 * np.sign(X)),
        (rx.TorqueSinceStart({"elbow": 0.1}, 0.25), TORQUE, "time", 0.1 * np.sin(np.pi * X / 2)),
        (rx.FrictionTemperature(level=0.1, per_kelvin=0.0), FRICTION, "temperature", 0.1 + 0 * X),
    ],
)
def test_the_hidden_torque_is_the_generators(effect, kind, follows, torque):
    found = hidden_torque(Case("one", ARM, (effect,)), curve(kind, follows), X)
    np.testing.assert_allclose(found, torque, atol=1e-5)


def test_what_is_no_torque_of_a_variable_is_not_shown():
    share = Case("one", ARM, (rx.FrictionDrift(0.1, 0.2, 5.0),))
    assert hidden_torque(share, curve(MOTOR, "session time"), X) is None
    for effect in (rx.BaseTilt(0.1, 0.0), rx.TorqueConstantDrift(1.0, 0.9, 5.0)):
        assert hidden_torque(Case("one", ARM, (effect,)), curve(TORQUE, "position"), X) is None


def test_the_picture_is_drawn(tmp_path):
    at, torque = [-1.0, 1.0], [0.1, -0.1]
    formula = {"text": "a * x", "values": {"a": -0.1}, "units": {"a": "N·m/(rad/s)"}}
    one = curve(TORQUE, "velocity") | {
        "at": at, "torque": torque, "low": torque, "high": torque, "unit": "rad/s",
        "formula": formula,
    }  # fmt: skip
    case = Case("viscous_two_joint_arm", ARM, (fx.ViscousFriction({"elbow": 0.1}),))
    draw([(case, {"curves": [one]})], tmp_path / "curves.png")
    assert (tmp_path / "curves.png").stat().st_size > 10_000
