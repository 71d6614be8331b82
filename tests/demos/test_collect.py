"""Demonstrations by an operator through the controller of a cell."""

import numpy as np
import pytest

from t2l.actions import make_control
from t2l.demos.collect import TABLE_COLUMNS, attempt, attempt_table, collect
from t2l.demos.operator import Person
from t2l.errors import OperatorError
from t2l.gains import Cell
from t2l.tasks import make_task

CENTRE = Cell(128, 8)
PERSON = Person(reaction_s=0.2, motor_noise=0.02, crossover_rad_s=[0.01, 3], practice=2)


@pytest.fixture(scope="module")
def patient(block_stack):
    """The task with the time that a person takes."""
    return make_task({**block_stack, "horizon_s": 12.0})


def control(task, kind="joint_target"):
    return make_control({"kind": kind}, CENTRE, task.robot, task.model)


@pytest.fixture(scope="module")
def collected(patient):
    return collect(patient, control(patient), 10, 3, 6, PERSON, np.random.default_rng(0))


def test_successes_are_kept_and_attempts_are_counted(patient, collected):
    table = attempt_table(collected, CENTRE)
    assert tuple(table.columns) == TABLE_COLUMNS
    assert table.success.sum() == 3
    assert table.success.iloc[-1]
    for a in collected:
        observation, action = a.episode
        assert observation.shape == (round(a.time_s * 50), len(patient.observation_names))
        assert action.shape == (len(observation), 8)
        assert action.dtype == observation.dtype == np.float32


def test_practice_tells_how_to_correct(collected):
    """Who hardly corrects does not arrive, for friction."""
    assert {a.crossover_rad_s for a in collected} == {3}


def test_the_same_seed_gives_the_same_data(patient):
    """And threads do not change it."""
    starts = patient.sample_starts(np.random.default_rng(0), 2)
    one, two = (
        attempt(patient, control(patient), 10, starts, PERSON, 3.0, np.random.default_rng(1), n)
        for n in (1, 2)
    )
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a.episode[0], b.episode[0])
        np.testing.assert_array_equal(a.episode[1], b.episode[1])


def test_actions_are_what_was_commanded(patient):
    """Of another kind of action, the same motion."""
    starts = patient.sample_starts(np.random.default_rng(0), 1)
    target, delta = (
        attempt(patient, control(patient, kind), 10, starts, PERSON, 3.0, np.random.default_rng(1))[
            0
        ]
        for kind in ("joint_target", "joint_delta")
    )
    np.testing.assert_array_equal(target.episode[0], delta.episode[0])
    q = target.episode[0][:, :7]
    np.testing.assert_allclose(target.episode[1][:, :7], q + delta.episode[1][:, :7], atol=1e-5)


def test_a_cell_where_the_operator_fails_is_named(block_stack):
    heavy = make_task({**block_stack, "block_mass_kg": 60.0, "horizon_s": 4.0})
    person = Person(0.2, 0.02, [2], 1)
    with pytest.raises(OperatorError, match=r"Kp 128, Kd 8: 0 of 2 attempts of the operator"):
        collect(heavy, control(heavy), 10, 2, 2, person, np.random.default_rng(0))
