import dataclasses

import numpy as np
import pytest

from t2l.identify.model import Model
from t2l.identify.units import questions
from tests.diagnose.made import measured, pendulum, recording, spinner, swing

SAGS = 'armature="0.005" damping="0.02"'


@pytest.fixture
def log(tmp_path):
    robot = pendulum(tmp_path, SAGS)
    log = recording(robot, swing(0.5, 0.3), duration_s=4.0)
    log = measured(log)
    return dataclasses.replace(log, dq=np.gradient(log.q, log.time, axis=0))


def asked(log, **changes):
    return questions(Model(log.robot), [dataclasses.replace(log, **changes)])


def test_nothing_is_asked_about_what_can_be(log):
    assert asked(log) == []


def test_a_question_is_asked_once_a_joint(log):
    log = dataclasses.replace(log, q=np.rad2deg(log.q), q_des=np.rad2deg(log.q_des))
    (question,) = questions(Model(log.robot), [log, log])
    assert "q.hinge goes to" in question
    assert "are they degrees?" in question


def test_turns_of_a_joint_with_limits_are_not_asked_about(log):
    """Its range refuses them, see `check_against_joint_ranges`."""
    path = log.robot
    with open(path) as file:
        text = file.read().replace("<joint ", '<joint range="-900 900" ')
    with open(path, "w") as file:
        file.write(text)
    assert not any("degrees" in q for q in asked(log, q=50 * log.q, q_des=50 * log.q_des))


def test_gains_that_are_registers(log):
    (question,) = asked(log, kp=1000 * log.kp)
    assert "Kp 20000 N·m/rad on joint hinge asks for" in question
    assert "register" in question
    (question,) = asked(log, kp=5 * log.kp, control_rate_hz=50.0)
    assert "natural frequency of 8 Hz, in a loop of 50 Hz" in question


def test_effects_of_the_model_count(log):
    stiff = dataclasses.replace(log, kp=40 * log.kp, control_rate_hz=50.0)
    heavy = Model(log.robot, {"armature": {"inertia": {"hinge": 5.0}}})
    assert questions(heavy, [stiff]) == []


def test_torque_beyond_what_the_file_allows(tmp_path, log):
    limited = pendulum(tmp_path, SAGS + ' actuatorfrcrange="-0.03 0.03"')
    (question,) = asked(dataclasses.replace(log, robot=limited), kp=10 * log.kp)
    assert "where the robot's file allows 0.03" in question


def test_gains_per_degree_do_not_hold_the_weight(log):
    (question,) = asked(log, kp=np.deg2rad(log.kp))
    assert "its weight takes" in question
    assert "N·m/deg" in question
    assert asked(log, kp=np.deg2rad(log.kp), gravity_compensation=True) == []


def test_no_weight_is_none_to_hold(tmp_path, log):
    assert asked(dataclasses.replace(log, robot=spinner(tmp_path)), kp=np.deg2rad(log.kp)) == []


def test_velocities_in_degrees(log):
    (question,) = asked(log, dq=np.rad2deg(log.dq))
    assert "dq.hinge is 57.3 times as fast as q.hinge changes" in question


def test_few_rows_or_none_at_once_raise_nothing(log):
    empty = np.full_like(log.q, np.nan)
    assert asked(log, q=empty) == []
    assert questions(Model(log.robot), [log.beginning(0.05)]) == []
