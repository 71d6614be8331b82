"""Springs and play between motor and link, along the motion that encoders show."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.detective.along_motion import AlongMotion, fit_along
from t2l.detective.fitted_set import Start
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.responses import added_torques
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor, Request
from tests.diagnose.made import measured, recording, swing, two_pendulums

NOISE = 1e-4
SPRING = {"stiffness": 30.0, "damping": 0.1}
PLAY = {"play": 0.03, "contact_time": 3e-3, "contact_damping": 1.0}
BARE = Layout(()), np.zeros(0)


def _made(tmp_path, effect: str, joints: tuple[str, ...], numbers, link: float, compensation=False):
    robot = two_pendulums(tmp_path)

    def commands(t):
        return np.column_stack([swing(0.5, 0.9)(t + 0.4), swing(0.5, 1.1)(t + 0.4)])

    said = {name: dict.fromkeys(joints, value) for name, value in numbers.items()}
    one = recording(robot, commands, joints=("left", "right"), duration_s=2.0)
    one = replace(one, gravity_compensation=compensation)
    one = measured(one, {effect: {**said, "encoder_on_link": link}}, NOISE)
    on = tuple(("left", "right").index(joint) for joint in joints)
    layout = Layout([Term(builtin()[effect], on)])
    values = {name: np.full(len(on), value) for name, value in numbers.items()}
    u = layout.encode({effect: {**values, "encoder_on_link": np.array([link])}})
    return Predictor(robot, [one], threads=1), layout, u


def _along(predictor, model):
    mask = np.ones(len(predictor.samples), bool)
    layout, u = model
    left = predictor.predict([Request(layout, u[None])])[0][0] - predictor.samples.q
    sections = linearised(predictor, *model, measured_motion(predictor, *model))
    return AlongMotion(predictor, sections, mask, (model, left), NOISE), np.sqrt(np.mean(left**2))


@pytest.mark.parametrize("link", [0.0, 1.0])
@pytest.mark.parametrize("joints", [("right",), ("left", "right")])
@pytest.mark.parametrize(("effect", "numbers"), [("joint_flexibility", SPRING), ("backlash", PLAY)])
def test_linearised_at_the_truth_only_noise_is_left(tmp_path, effect, numbers, joints, link):
    predictor, layout, u = _made(tmp_path, effect, joints, numbers, link)
    came, left = _along(predictor, BARE)
    at_truth, _ = _along(predictor, (layout, u))
    assert min(left, came.rmse) > 10 * NOISE
    assert at_truth.rmse < 1.1 * NOISE


@pytest.mark.parametrize("link", [0.0, 1.0])
def test_what_gives_is_told_from_the_model_as_it_came(tmp_path, link):
    """Where the loop is linearised without it, it explains most; less stiff or stiffer, less."""
    predictor, layout, u = _made(tmp_path, "joint_flexibility", ("right",), SPRING, link)
    along, left = _along(predictor, BARE)
    folds = np.zeros((len(along.residual), 1), int)
    of = {}
    for times in (0.3, 1.0, 3.0):
        moved = u + np.log(times) * np.array(
            [s.parameter.name == "stiffness" for s in layout.slots]
        )
        (fit,) = fit_along([Start(layout, moved)], along, folds, 0)
        of[times] = fit.rmse
    assert of[1.0] < min(0.4 * left, of[0.3], of[3.0])


def test_a_variant_without_it_is_led_as_the_plant_that_does_not_give(tmp_path):
    """From a model with a spring to one without: what is added and taken away cancels."""
    predictor, layout, u = _made(tmp_path, "joint_flexibility", ("right",), SPRING, 0.0)
    along, _ = _along(predictor, BARE)
    section, bare = along.sections[0], (BARE[0], BARE[1][None])
    (there,) = added_torques(predictor, section, BARE, [(layout, u[None])])
    (back,) = added_torques(predictor, section, (layout, u), [bare])
    assert np.abs(there).max() > 0.01
    assert np.allclose(there, -back, atol=1e-4 * np.abs(there).max())


@pytest.mark.parametrize("compensation", [False, True, "continuous"])
def test_a_link_on_a_spring_has_the_weight_of_where_it_hangs(tmp_path, compensation):
    numbers = {"stiffness": 30.0, "damping": 1.0}
    joints = ("left", "right")
    hidden = tmp_path, "joint_flexibility", joints, numbers, 0.0, compensation
    predictor, layout, u = _made(*hidden)
    along, left = _along(predictor, BARE)
    folds = np.zeros((len(along.residual), 1), int)
    (fit,) = fit_along([Start(layout, u)], along, folds, 0)
    # where the loop answers as if the link hung where the motor is, a fifth is left
    assert left > 10 * NOISE
    assert fit.rmse < 0.1 * left
