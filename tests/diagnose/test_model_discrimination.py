import numpy as np
import pytest

from t2l.diagnose.model_discrimination import separating_experiment
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from tests.diagnose.made import pendulum, predict, swings

NOISE = 1e-4


@pytest.fixture(scope="module")
def predictor(tmp_path_factory):
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    recordings = swings(robot, noise_rad=NOISE, duration_s=1.0, control_rate_hz=200.0)
    return Predictor(robot, recordings[1:2])


def vector(predictor, effects):
    return Model(predictor.robot, effects).vector(predictor.joints)


def experiment(predictor, first, second):
    return separating_experiment(
        predictor, vector(predictor, first), vector(predictor, second), NOISE
    )


def hinge(name, **values):
    return {name: {k: {"hinge": v} for k, v in values.items()}}


def test_friction_and_gains_that_look_alike_are_told_apart_at_other_gains(predictor):
    """Where they were recorded, at Kd 0.8, both explanations are the same."""
    friction = hinge("viscous_friction", damping=0.4)
    gains = hinge("controller_gains", kp_factor=1.0, kd_factor=1.5)
    (recorded,) = predictor.recordings
    before = predict(recorded, friction) - predict(recorded, gains)
    found = experiment(predictor, friction, gains)
    assert found.difference_rad > 3 * np.sqrt(np.mean(before**2))
    assert found.kd[0] != pytest.approx(recorded.kd[0])
    assert found.motion in found.sentence
    assert f"{found.kp[0]:.2g}" in found.sentence


def test_explanations_that_are_the_same_are_told_apart_by_nothing(predictor):
    gains = hinge("controller_gains", kp_factor=0.8, kd_factor=0.8)
    constant = hinge("torque_constant", factor=0.8)
    found = experiment(predictor, gains, constant)
    assert found.difference_rad < 1e-9
    assert found.sentence.startswith("No motion tried tells them apart")


def test_a_slow_motion_shows_friction_and_a_fast_one_inertia(predictor):
    rubbing = experiment(predictor, hinge("coulomb_friction", torque=0.05), {})
    heavy = experiment(predictor, hinge("armature", inertia=0.01), {})
    assert rubbing.kp[0] < heavy.kp[0] or "slow" in rubbing.motion
    assert "slow" not in heavy.motion
