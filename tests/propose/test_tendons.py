"""What pulls on two joints at once is one curve, whose lever arms the two tell."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.effects.law import TENDON, Curve, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.propose.artefacts import formula_law, with_formula
from t2l.propose.expression import Formula
from t2l.propose.proposal import LAW
from t2l.propose.tendons import (
    BETWEEN,
    RATIOS,
    Lever,
    best_of_each_joint,
    lever,
    levers,
    pairs,
)
from t2l.propose.tendons import measured as measured_variables
from tests.diagnose.made import measured, predict, recording, swing, two_pendulums
from tests.export.test_export import exported
from tests.propose.made import learn

CABLE = Law(TENDON, "right", "position", "left")
STIFFNESS, RATIO, REST = 1.0, -0.7, 0.2


def cable(stiffness=STIFFNESS, ratio=RATIO, rest=REST):
    at = np.array([-3.0, 3.0])
    return Curve(CABLE, tuple(at), tuple(-stiffness * (at - rest)), ratio)


def commands(t):
    return np.column_stack([swing(0.5, hz)(t) for hz in (0.7, 1.1)])


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return two_pendulums(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def predictor(robot):
    return Predictor(robot, [measured(recording(robot, commands, duration_s=4.0))], threads=1)


def test_a_line_is_a_cable(robot):
    one = recording(robot, commands)
    values = {"stiffness": STIFFNESS, "damping": 0.0, "ratio": RATIO, "rest": REST, "before": 1.0}
    effects = {"joint_coupling": {name: {"right": value} for name, value in values.items()}}
    as_line = predict(one, model=Model(robot, learned=(cable(),)))
    np.testing.assert_allclose(as_line, predict(one, effects), atol=1e-9)
    assert np.abs(as_line - predict(one)).max() > 1e-2


@given(st.sampled_from(RATIOS.tolist()), st.floats(-3.0, 3.0), st.floats(0.3, 3.0))
def test_what_two_joints_lack_tells_the_ratio(predictor, ratio, bend, spent):
    x = measured_variables(predictor)["position"][:, ::-1]
    length = x[:, 0] + ratio * x[:, 1]
    tension = np.sin(length) + bend * length**2
    missing = np.stack([tension, ratio * tension], axis=1)
    block = np.arange(len(x)) // 50
    found = lever(x, missing, block, (1.0, spent)).ratio
    # to one step of the ratios that are tried
    assert 1.05 / BETWEEN**2 < found / ratio < BETWEEN**2 / 1.05


def test_of_what_is_missing_nowhere_no_tendon_tells(predictor):
    none = np.zeros(len(predictor.samples))
    assert levers(predictor, none, pairs(predictor.joints), (1.0, 1.0)) == {}


def test_joints_that_are_measured_in_turn_have_the_same_tendon(robot):
    """An empty cell means that a joint was not sampled."""
    whole = measured(
        recording(robot, commands, duration_s=4.0), model=Model(robot, learned=(cable(),))
    )
    q = whole.q.copy()
    q[::2, 0], q[1::2, 1] = np.nan, np.nan
    found = []
    for one in (whole, dataclasses.replace(whole, q=q)):
        predictor = Predictor(robot, [one], threads=1)
        layout, u = Model(robot).vector(predictor.joints)
        left = predictor.samples.q - predictor.predict([Request(layout, u[None])])[0][0]
        found.append(levers(predictor, left, [CABLE], (1.0, 1.0))[CABLE].ratio)
    assert found[0] == found[1]
    assert 1 / BETWEEN < found[0] / RATIO < BETWEEN


def test_tendons_are_the_best_of_either_joint():
    laws = {name: Law(TENDON, name[1], "position", name[0]) for name in ("ab", "ac", "bc")}
    found = {
        law: Lever(1.0, square) for law, square in zip(laws.values(), (3.0, 2.0, 1.0), strict=True)
    }
    assert list(best_of_each_joint(found)) == [laws["ab"], laws["ac"]]


def test_a_cable_is_recovered(robot):
    model = Model(robot, learned=(cable(),))
    logs = [
        measured(recording(robot, commands, f"log{i}", kp=kp), None, 1e-4, i, model)
        for i, kp in enumerate((20.0, 8.0))
    ]
    found = learn(robot, logs)
    assert found.verdict == LAW
    assert [one.curve.law for one in found.learned] == [CABLE]
    (one,) = found.learned
    assert one.curve.ratio == pytest.approx(RATIO, rel=0.02)
    slope, level = np.polyfit(one.curve.at, one.curve.torque, 1)
    assert slope == pytest.approx(-STIFFNESS, rel=0.05)
    assert level == pytest.approx(STIFFNESS * REST, rel=0.1)
    assert found.choice_rmse_rad < 1.2 * found.noise_floor_rad


@pytest.mark.parametrize("follows", ["position", "velocity"])
def test_its_formula_and_its_export_move_the_robot_as_the_curve_does(robot, tmp_path, follows):
    law = Law(TENDON, "right", follows, "left")
    curve = Curve(law, (-30.0, 30.0), (3.2, -2.8), RATIO)
    values, units = {"a": 0.2, "b": -0.1}, {"a": "N·m", "b": f"N·m/({law.unit})"}
    formula = formula_law(law, Formula("a + b * x", values, units), RATIO)
    spoken = with_formula(Model(robot), formula, values)
    one = recording(robot, commands)
    by_formula = predict(one, model=spoken)
    by_curve = predict(one, model=Model(robot, learned=(curve,)))
    np.testing.assert_allclose(by_formula, by_curve, atol=1e-9)
    for model in (spoken, Model(robot, learned=(curve,))):
        content, error, log = exported(
            tmp_path / "out", robot, model.effects, learned=model.learned, commands=commands,
            formulas=model.formulas,
        )  # fmt: skip
        moved = np.sqrt(np.mean((predict(log, model=model) - predict(log)) ** 2))
        assert not content["not_carried"]
        assert moved > 1e-3
        assert error < max(0.01 * moved, 3e-5)
