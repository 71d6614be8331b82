"""What pulls on two joints at once is one curve, whose lever arms the two tell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from t2l.effects.law import TENDON, TORQUE, Curve, Law
from t2l.effects.registry import load
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.bases import effect_of, tabulated
from t2l.propose.dictionary import weights_in
from t2l.propose.effect_file import effect_name, effect_text
from t2l.propose.expression import Formula
from t2l.propose.proposal import LAW
from t2l.propose.refit import State, with_law
from t2l.propose.simplify import on_one_joint
from t2l.propose.tendons import RATIOS, lever, paired
from tests.diagnose.made import measured, predict, recording, swing, two_pendulums
from tests.export.test_export import exported
from tests.propose.test_search import learn

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
    values = {"stiffness": STIFFNESS, "damping": 0.0, "ratio": RATIO, "rest": REST}
    effects = {"joint_coupling": {name: {"right": value} for name, value in values.items()}}
    as_line = predict(one, model=Model(robot, learned=(cable(),)))
    np.testing.assert_allclose(as_line, predict(one, effects), atol=1e-9)
    assert np.abs(as_line - predict(one)).max() > 1e-2


@given(st.sampled_from(np.concatenate(RATIOS).tolist()), st.floats(-3.0, 3.0), st.floats(0.3, 3.0))
def test_what_two_joints_lack_tells_the_ratio(predictor, ratio, bend, size):
    samples = predictor.samples
    here, there = paired(predictor, CABLE, samples.q)
    x = here + ratio * there
    tension = np.sin(x) + bend * x**2
    missing = np.zeros(len(samples))
    missing[samples.joint == 1], missing[samples.joint == 0] = tension, ratio * tension
    found = lever(predictor, CABLE, missing, (1.0, size)).ratio
    # to one step of the ratios that are tried
    assert 5**-0.21 < found / ratio < 5**0.21


def test_a_cable_is_recovered(robot):
    model = Model(robot, learned=(cable(),))
    logs = [
        measured(recording(robot, commands, f"log{i}", kp=kp), None, 1e-4, i, model)
        for i, kp in enumerate((20.0, 8.0))
    ]
    found = learn(robot, logs)
    assert found.verdict == LAW
    (one,) = found.learned
    assert one.curve.law == CABLE
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
    path, name = tmp_path / "own.py", effect_name(law)
    path.write_text(effect_text(law, Formula("a + b * x", values, units), RATIO))
    assert name in load([path])
    effects = {name: {key: {"right": value} for key, value in values.items()}}
    one = recording(robot, commands)
    by_formula = predict(one, model=Model(robot, effects, (path,)))
    by_curve = predict(one, model=Model(robot, learned=(curve,)))
    np.testing.assert_allclose(by_formula, by_curve, atol=1e-9)
    for part in ({"effects": effects, "files": (path,)}, {"effects": {}, "learned": (curve,)}):
        content, error, log = exported(tmp_path / "out", robot, **part, commands=commands)
        model = Model(robot, part["effects"], part.get("files", ()), part.get("learned", ()))
        moved = np.sqrt(np.mean((predict(log, model=model) - predict(log)) ** 2))
        assert not content["not_carried"]
        assert moved > 1e-3
        assert error < max(0.01 * moved, 3e-5)


@pytest.mark.parametrize(("ratio", "joint"), [(0.3, "right"), (-0.3, "right"), (-3.0, "left")])
def test_a_tendon_becomes_the_law_of_the_joint_at_which_it_pulls_most(robot, ratio, joint):
    effect = effect_of(CABLE, (-1.0, 2.0), 1.0, ratio=ratio)
    bare = State(*Model(robot).vector(("left", "right")))
    weights = np.random.default_rng(0).normal(size=effect.basis.shape[1])
    state = with_law(bare, effect, weights, 2.0, ("left", "right"))
    (found,) = on_one_joint(state, effect, ("left", "right"))
    ((own, penalty),) = found.laws
    assert own.law == Law(TORQUE, joint, "position", joint)
    assert penalty == 2.0
    x = np.linspace(-0.6, 0.3, 20)
    curve, whole = (
        tabulated(one, s.u[weights_in(s.layout, one)]) for one, s in ((own, found), (effect, state))
    )
    # at the other joint's zero
    lever = ratio if joint == "left" else 1.0
    np.testing.assert_allclose(curve(x), lever * whole(lever * x), rtol=0.02, atol=0.02)
