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


def test_constants_share_a_panel_and_letters_are_as_large_as_the_pages(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(
        "benchmarks.learned_curves.write", lambda figure, paths: drawn.append(figure)
    )
    friction = Case("test16_coulomb_friction", ARM, (fx.CoulombFriction({"elbow": 0.1}),))
    ends = {"at": [0.0, 1.0], "unit": "", "formula": None}
    one = curve(FRICTION, "constant") | ends | {
        "torque": [0.101] * 2, "low": [0.099] * 2, "high": [0.103] * 2,
    }  # fmt: skip
    viscous = Case("test16_viscous_friction", ARM, (fx.ViscousFriction({"elbow": 0.1}),))
    line = curve(TORQUE, "velocity") | {
        "at": [-1.0, 1.0], "unit": "rad/s", "formula": None,
        "torque": [0.1, -0.1], "low": [0.1, -0.1], "high": [0.1, -0.1],
    }  # fmt: skip
    draw([(friction, {"curves": [one]})] * 9 + [(viscous, {"curves": [line]})] * 15, tmp_path / "x")
    (figure,) = drawn
    assert figure.get_size_inches()[0] < 10
    panels = [panel for part in figure.subfigs for panel in part.axes if panel.axison]
    assert len(panels) == 16
    texts = [t for p in panels for t in (*p.get_xticklabels(), *p.get_yticklabels(), p.title)]
    assert min(text.get_fontsize() for text in texts) >= 8
    # one per cent above what is hidden, with a band of two either way
    points = [line.get_xdata() for line in panels[-1].lines if line.get_marker() == "o"]
    assert len(points) == 9
    np.testing.assert_allclose(points, 1.0)
