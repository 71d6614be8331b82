"""The missing torque, and what it follows, of machines that lack one thing."""

import numpy as np
import pytest

from t2l.diagnose.conditions import features
from t2l.diagnose.explained_variance import by_bins, explained_variance, proportion
from t2l.diagnose.inverse_dynamics_residual import missing_torque
from t2l.diagnose.oscillation import swing
from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor, Request
from tests.diagnose.made import pendulum, swings


def _analysis(recordings):
    predictor = Predictor(recordings[0].robot, recordings, threads=1)
    (q,), (dq,) = predictor.predict([Request(Layout(()), np.zeros((1, 0)))], velocity=True)
    residual = predictor.samples.q - q[0]
    return predictor, residual, features(predictor, q[0], dq[0])


CASES = {
    "coulomb_friction": ({"torque": {"hinge": 0.06}}, "direction"),
    "viscous_friction": ({"damping": {"hinge": 0.05}}, "velocity"),
    "armature": ({"inertia": {"hinge": 0.01}}, "acceleration"),
    "torque_offset": ({"torque": {"hinge": 0.2}}, "constant"),
}


@pytest.mark.parametrize("effect", CASES)
def test_the_condition_of_an_effect_comes_first(tmp_path, effect):
    values, condition = CASES[effect]
    recordings = swings(pendulum(tmp_path), {effect: values}, noise_rad=2e-5)
    predictor, residual, under = _analysis(recordings)
    first = explained_variance(predictor, residual, under)[0]
    assert first.condition == condition
    assert first.fraction > 0.5
    assert first.proportional
    assert first.joints == {"hinge": pytest.approx(first.fraction)}


def test_the_missing_torque_is_the_friction_at_every_gain(tmp_path):
    recordings = swings(pendulum(tmp_path), {"coulomb_friction": {"torque": {"hinge": 0.06}}}, 1e-5)
    predictor, residual, under = _analysis(recordings)
    missing = missing_torque(predictor, residual)
    for recording in range(3):
        moving = (np.abs(under["velocity"]) > 0.5) & (predictor.samples.recording == recording)
        level = np.median(missing[moving] * under["direction"][moving])
        assert level == pytest.approx(-0.06, rel=0.15)


def test_noise_follows_nothing(tmp_path):
    predictor, residual, under = _analysis(swings(pendulum(tmp_path), None, 1e-4))
    assert explained_variance(predictor, residual, under) == []


def test_any_function_of_a_condition_is_found_by_bins_and_a_mere_mean_is_not():
    rng = np.random.default_rng(0)
    x, block = rng.uniform(-1, 1, 3000), np.repeat(np.arange(3), 1000)
    assert by_bins(np.cos(6 * x), x, block) > 0.8
    assert proportion(np.cos(6 * x), x, block) < 0.05
    assert by_bins(5.0 + rng.normal(size=3000), x, block) < 0.02
    assert proportion(3 * x, x, block) == pytest.approx(1.0)


def test_a_swing_in_time_is_found_whatever_the_commands(tmp_path):
    recordings = swings(pendulum(tmp_path), None, 2e-5, duration_s=4.0)
    predictor, _, under = _analysis(recordings)
    samples = predictor.samples
    # 0.04 N·m at 1.7 Hz, felt through each recording's stiffness
    kp = np.array([r.kp[0] for r in recordings])[samples.recording]
    wave = np.sin(2 * np.pi * 1.7 * samples.time + 2.0 * samples.recording)
    first = explained_variance(predictor, 0.04 * wave / kp, under)[0]
    assert first.frequency_hz == pytest.approx(1.7, abs=0.06)
    assert "swings at 1.7 Hz in time" in first.sentence


def test_a_frequency_that_is_commanded_is_no_swing():
    time, recording = np.tile(np.arange(400) / 100, 2), np.repeat([0, 1], 400)
    wave = np.sin(2 * np.pi * time)
    noise = np.random.default_rng(0).normal(size=800)
    assert swing(wave, noise, time, recording) == (
        pytest.approx(1.0, abs=0.03),
        pytest.approx(1.0, abs=0.05),
    )
    assert swing(wave, wave, time, recording)[1] < 0.2
    assert swing(wave[:3], noise[:3], time[:3], recording[:3]) == (0.0, 0.0)
