"""What swings from a phase that nobody knows: along the motion, and in the search."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from t2l.detective.along_motion import fit_along
from t2l.detective.data_split import split
from t2l.detective.fitted_set import Start
from t2l.detective.free_phases import best_turns
from t2l.detective.search import search
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.errors import ConfigurationError
from t2l.identify.model import Model, read_model
from t2l.identify.prediction import Request
from tests.detective.test_along_motion import along_of, rms
from tests.diagnose.made import measured, pendulum, recording, swing

NOISE_RAD = 1e-4
NAME = "free_running_torque"
AMPLITUDE, FREQUENCY = 0.1, 1.3
BEGINS = (0.4, 2.5, -1.9, 1.1)  # rad, of each recording
GAINS = ((5.0, 0.3, 0.7), (20.0, 0.8, 0.9), (80.0, 2.0, 1.1), (20.0, 0.8, 1.2))


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def shaken(robot, begins=BEGINS, others=None, clock_s=0.0):
    """Recordings of a machine that a torque shakes; `clock_s` lies between their beginnings."""
    logs = []
    for i, ((kp, kd, hz), begin) in enumerate(zip(GAINS, begins, strict=True)):
        torque = {"amplitude": AMPLITUDE, "frequency": FREQUENCY, "phase": begin}
        hidden = {"periodic_torque": {k: {"hinge": v} for k, v in torque.items()}}
        made = recording(robot, swing(0.5, hz), f"{i}", kp, kd, 2.5, control_rate_hz=250.0)
        made = replace(made, time=made.time + i * clock_s)
        logs.append(measured(made, hidden | (others or {}), NOISE_RAD, i))
    return logs


def test_the_truth_leaves_noise_along_the_motion_and_its_numbers_are_found(robot):
    logs = shaken(robot)
    data = split(robot, logs[:3], logs[3:], threads=1)
    along, so_far = along_of(data)
    layout = Layout([Term(builtin()[NAME], (0,))])
    values = {"amplitude": np.array([0.06]), "frequency": np.array([FREQUENCY + 0.02])}
    (found,) = fit_along([Start(layout, layout.encode({NAME: values}))], along, data.folds)
    assert rms(so_far.residual) > 30 * NOISE_RAD
    assert rms(found.residual) < 2 * NOISE_RAD
    assert found.u == pytest.approx([AMPLITUDE, FREQUENCY], rel=0.02)
    # a phase of each recording, the two numbers, the name
    assert found.phases == 3
    assert found.complexity == 6


def test_it_is_named_where_no_clock_is_shared_and_foretells_what_is_held_out(robot):
    hidden = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
    logs = shaken(robot, others=hidden)
    data = split(robot, logs[:3], logs[3:], threads=1)
    found = search(Model(robot), data).model
    assert set(found.effects) == {NAME, "coulomb_friction"}
    assert found.effects[NAME]["amplitude"]["hinge"] == pytest.approx(AMPLITUDE, rel=0.02)
    assert found.effects[NAME]["frequency"]["hinge"] == pytest.approx(FREQUENCY, rel=0.005)
    layout, u = found.vector(data.test.joints)
    error = data.test.predict([Request(layout, u[None])])[0][0] - data.test.samples.q
    assert rms(error) < 1.1 * NOISE_RAD


def test_where_the_clock_is_shared_one_phase_is_fewer_numbers(robot):
    logs = shaken(robot, begins=(0.4,) * 4, clock_s=2.83)
    found = search(Model(robot), split(robot, logs[:3], logs[3:], threads=1)).model
    assert set(found.effects) == {"periodic_torque"}


def test_of_one_recording_no_phase_is_free(robot):
    logs = shaken(robot)
    assert builtin()[NAME].may_act(logs)
    assert not builtin()[NAME].may_act(logs[:1])


def test_a_torque_too_short_for_a_period_has_no_rate():
    effect, one = builtin()[NAME], np.zeros(1)
    assert effect.read_off(one, one, one, one) is None


def test_a_frequency_that_no_torque_has_is_named(robot, tmp_path):
    text = f"robot: {robot}\neffects:\n  {NAME}:\n    amplitude: {{hinge: 0.1}}\n"
    (tmp_path / "model.yaml").write_text(text + "    frequency: {hinge: 0}\n")
    with pytest.raises(ConfigurationError, match=rf"effects.{NAME}.frequency = 0 Hz; allowed 0.02"):
        read_model(tmp_path / "model.yaml")


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_no_other_angle_is_better(seed, places):
    rng = np.random.default_rng(seed)
    waves, left = rng.normal(size=(2 * places, 40)), rng.normal(size=40)
    # joints that hardly move each other, as of a robot
    for i in range(places):
        waves[2 * i : 2 * i + 2, np.arange(40) % places != i] *= 0.1
    gram, along = (waves @ waves.T)[None], (waves @ left)[None]
    (w,) = best_turns(gram, along)
    np.testing.assert_allclose(w.reshape(-1, 2) ** 2 @ np.ones(2), 1.0)
    least = np.sum((left + w @ waves) ** 2)
    for i in range(places):
        for angle in np.linspace(0, 2 * np.pi, 50):
            other = w.copy()
            other[2 * i : 2 * i + 2] = np.cos(angle), np.sin(angle)
            assert np.sum((left + other @ waves) ** 2) > least - 0.02 * least
