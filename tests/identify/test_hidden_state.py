"""Logs that begin in motion, of joints with a far side that no encoder sees."""

import dataclasses

import numpy as np
import pytest

from t2l.identify.hidden_state import Beginning
from t2l.sim.schedule import Schedule
from tests.diagnose.made import measured, pendulum, predict, recording, step, swing

NOISE_RAD = 1e-4
SPRING = {"stiffness": {"hinge": 30.0}, "damping": {"hinge": 0.03}}
PLAY = {"play": {"hinge": 0.03}, "contact_time": {"hinge": 2e-3}, "contact_damping": {"hinge": 0.2}}


def in_motion(robot, effects, from_s):
    """The recording of a machine with `effects`, from `from_s` on."""
    whole = recording(robot, swing(0.6, 1.1), kp=10, kd=0.4, duration_s=2.0, row_rate_hz=200.0)
    whole = measured(whole, effects, NOISE_RAD)
    rows = whole.time >= from_s
    time = whole.time[rows] - whole.time[rows][0]
    return dataclasses.replace(whole, time=time, q_des=whole.q_des[rows], q=whole.q[rows])


@pytest.mark.parametrize("link", [0.0, 1.0])
def test_a_spring_that_is_bent_and_swings_at_the_start_is_predicted_to_the_noise(tmp_path, link):
    effects = {"joint_flexibility": SPRING | {"encoder_on_link": link}}
    made = in_motion(pendulum(tmp_path), effects, 0.8)
    error = predict(made, effects) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 1.15 * NOISE_RAD


def test_teeth_may_touch_on_either_side_at_the_start(tmp_path):
    effects = {"backlash": PLAY | {"encoder_on_link": 0.0}}
    made = in_motion(pendulum(tmp_path), effects, 0.8)
    error = predict(made, effects) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 3 * NOISE_RAD


def test_a_log_that_begins_at_rest_starts_under_its_load(tmp_path):
    effects = {"joint_flexibility": SPRING | {"encoder_on_link": 0.0}}
    made = recording(pendulum(tmp_path), step(0.3, at_s=0.25), duration_s=0.5)
    here = measured(made, effects)
    moved = dataclasses.replace(here, q=here.q + np.linspace(0, 0.01, len(here.q))[:, None] ** 2)
    # what was measured later does not change how it starts
    np.testing.assert_array_equal(predict(here, effects), predict(moved, effects))


def test_simulations_that_fall_over_leave_a_start_where_it_is():
    # a step of any unknown, and the model diverges: no slope says anything, and all say the same
    measured = np.linspace(1e-6, 2e-6, 12)
    schedule = Schedule(
        0.001, np.zeros((1, 1, 2)), *np.zeros((4, 1, 2)), *np.zeros((2, 1), bool), np.arange(1)
    )
    wanted = (np.zeros(12, int), np.arange(12), np.zeros(12, int), np.arange(12) % 2)
    beginning = Beginning(schedule, wanted, measured, noise_rad=1e-6)

    def predict(starts):
        return np.where(starts.any(axis=(1, 2, 3))[:, None], np.nan, np.zeros(12))

    found = beginning.estimate(predict, [0, 1], np.zeros((1, 1, 2)))
    assert (found == 0.0).all()
