"""Logs that begin in motion: with what velocity, and where what no encoder sees is."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from t2l.effects.term import Layout
from t2l.identify.hidden_state import Beginning
from t2l.identify.initial_state import slope_of_motion, start_state
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.sim.schedule import Schedule
from tests.diagnose.made import (
    WEIGHT,
    hold,
    measured,
    pendulum,
    predict,
    recording,
    step,
    swing,
    two_pendulums,
)

NOISE_RAD = 1e-4
PLAIN = Request(Layout(()), np.zeros((1, 0)))
SPRING = {"stiffness": {"hinge": 30.0}, "damping": {"hinge": 0.03}}
PLAY = {"play": {"hinge": 0.03}, "contact_time": {"hinge": 2e-3}, "contact_damping": {"hinge": 0.2}}


def in_motion(robot, effects, from_s, model=None):
    """The recording of a machine with `effects`, from `from_s` on."""
    whole = recording(robot, swing(0.6, 1.1), kp=10, kd=0.4, duration_s=2.0, row_rate_hz=200.0)
    whole = measured(whole, effects, NOISE_RAD, model=model)
    rows = whole.time >= from_s
    time = whole.time[rows] - whole.time[rows][0]
    return dataclasses.replace(whole, time=time, q_des=whole.q_des[rows], q=whole.q[rows])


@pytest.mark.parametrize("link", [0.0, 1.0])
def test_a_spring_that_is_bent_and_swings_at_the_start_is_predicted_to_the_noise(tmp_path, link):
    effects = {"joint_flexibility": SPRING | {"encoder_on_link": link}}
    made = in_motion(pendulum(tmp_path), effects, 0.8)
    error = predict(made, effects) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 1.15 * NOISE_RAD


@pytest.mark.parametrize("link", [0.0, 1.0])
@pytest.mark.parametrize("compensation", [False, "continuous"])
def test_a_spring_that_its_load_bends_far_begins_at_rest(tmp_path, link, compensation):
    """Where it is bent its load is another than where it is not."""
    stiffness, kp, at = 3.0, 20.0, 0.8
    soft = {"stiffness": {"hinge": stiffness}, "damping": {"hinge": 0.05}}
    made = recording(pendulum(tmp_path), hold(at), kp=kp, duration_s=0.5)

    def lacks(bent):
        return stiffness * bent + WEIGHT * np.sin(at + (1 - link) * bent)

    load = -stiffness * brentq(lacks, -0.5, 0.0)
    command = at if compensation else at + load / kp
    made = dataclasses.replace(
        made, q_des=np.full_like(made.q, command), gravity_compensation=compensation
    )
    q = predict(made, {"joint_flexibility": soft | {"encoder_on_link": link}})
    # of a load of where it is not bent it would swing by 0.02 rad
    assert np.abs(q - at).max() < 1e-3


def test_teeth_may_touch_on_either_side_at_the_start(tmp_path):
    effects = {"backlash": PLAY | {"encoder_on_link": 0.0}}
    made = in_motion(pendulum(tmp_path), effects, 0.8)
    error = predict(made, effects) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 3 * NOISE_RAD


BRISTLES = {"coulomb": {"hinge": 0.15}, "presliding": {"hinge": 0.02}}
INTEGRAL = {"gain": {"hinge": 12.0}, "limit": {"hinge": 0.4}}
ELEMENTS = {
    "torque_1": {"hinge": 0.1}, "radius_1": {"hinge": 0.02},
    "torque_2": {"hinge": 0.1}, "radius_2": {"hinge": 0.3},
    "torque_3": {"hinge": 0.0}, "radius_3": {"hinge": 0.3},
}  # fmt: skip


@pytest.mark.parametrize(
    ("effects", "times"),
    [
        ({"dahl_friction": BRISTLES}, 1.15),
        ({"integral_action": INTEGRAL}, 1.15),
        # one number for two elements
        ({"maxwell_slip_friction": ELEMENTS}, 1.5),
    ],
    ids=["bristles", "integral", "elements"],
)
@pytest.mark.parametrize("from_s", [0.5, 0.655, 0.8])
def test_what_is_held_where_a_motion_turns_is_predicted_to_the_noise(
    tmp_path, effects, times, from_s
):
    robot = pendulum(tmp_path)
    model = Model(robot, effects)
    made = in_motion(robot, None, from_s, model)
    layout, u = model.vector(made.joints)
    predictor = Predictor(robot, [made], threads=1, in_motion=True)
    error = predictor.predict([Request(layout, u[None])])[0][0] - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < times * NOISE_RAD


def test_an_integral_that_friction_balances_is_predicted_to_the_noise(tmp_path):
    """It has not wound up yet where the log begins, and friction holds the joint meanwhile."""
    effects = {
        "integral_action": {"gain": {"hinge": 2.0}, "limit": {"hinge": 2.0}},
        "coulomb_friction": {"torque": {"hinge": 0.2}},
    }
    commands = lambda t: 0.3 * (t > 0.1) + 0.2 * (t > 1.2)  # noqa: E731
    whole = recording(pendulum(tmp_path), commands, kp=10, kd=0.4, duration_s=2.0)
    whole = measured(whole, effects, NOISE_RAD)
    rows = whole.time >= 1.1
    part = {"time": whole.time[rows] - 1.1, "q_des": whole.q_des[rows], "q": whole.q[rows]}
    made = dataclasses.replace(whole, **part)
    assert start_state(made)[1] == 0.0
    error = predict(made, effects) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 1.3 * NOISE_RAD
    # it is told by what comes after, not by balance alone
    bare = {"integral_action": effects["integral_action"]}
    assert rms_of(made, bare) > 10 * rms_of(made, effects)


def rms_of(made, effects):
    return np.sqrt(np.mean((predict(made, effects) - made.q.ravel()) ** 2))


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
    beginning = Beginning(schedule, wanted, measured, 1e-6, np.zeros((1, 2)))

    def predict(starts):
        return np.where(starts.any(axis=(1, 2, 3))[:, None], np.nan, np.zeros(12))

    found = beginning.estimate(predict, [0, 1], np.zeros((1, 1, 2)))
    assert (found == 0.0).all()


def late_rows(robot, from_s=0.8, late_s=1e-3, seed=0, effects=None, **changes):
    """A log that begins in motion, with rows that came late, and the velocity it begins with."""
    rng = np.random.default_rng(seed)
    whole = recording(robot, swing(0.6, 1.1), kp=10, kd=0.4, duration_s=2.0, row_rate_hz=200.0)
    whole = dataclasses.replace(whole, **changes)
    late = np.minimum(rng.exponential(late_s, len(whole.time)), 0.8 / 200)
    first = round(200 * from_s)
    time = whole.time + np.where(np.arange(len(late)) % first == 0, 0.0, late)
    whole = dataclasses.replace(whole, time=time)
    layout, u = Model(robot, effects or {}).vector(whole.joints)
    request = Request(layout, u[None])
    (q,), (dq,) = Predictor(robot, [whole], threads=1).predict([request], velocity=True)
    q = q[0] + NOISE_RAD * rng.normal(size=len(time))
    part = {"time": time[first:] - time[first], "q_des": whole.q_des[first:], "q": q[first:, None]}
    return dataclasses.replace(whole, **part), dq[0][first]


def predicted(log, **how):
    """Positions (n,) and the velocity with which they begin, of the plain model."""
    predictor = Predictor(log.robot, [log], threads=1, **how)
    (q,), (dq,) = predictor.predict([PLAIN], velocity=True)
    return q[0], dq[0][0]


def rms_rad(log, **how):
    return np.sqrt(np.mean((predicted(log, **how)[0] - log.q[:, 0]) ** 2))


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@settings(deadline=None, max_examples=15)
@given(from_s=st.integers(60, 180), late_s=st.floats(0.0, 2e-3), seed=st.integers(0, 999))
def test_the_first_velocity_is_found_under_late_rows(robot, from_s, late_s, seed):
    log, dq = late_rows(robot, from_s / 200, late_s, seed)
    assert predicted(log, in_motion=True)[1] == pytest.approx(dq, abs=0.02)


def test_what_is_left_under_late_rows_is_the_noise(robot):
    made = [late_rows(robot, late_s=1e-3, seed=seed) for seed in range(10)]
    off = [predicted(log)[1] - dq for log, dq in made]
    slopes = [start_state(log)[1][0] - dq for log, dq in made]
    assert np.std(off) < 0.006 < 0.5 * np.std(slopes)
    assert np.mean([rms_rad(log) for log, _ in made]) < 1.1 * NOISE_RAD


@pytest.mark.parametrize(
    "effects",
    [
        {"torque_offset": {"torque": {"hinge": 0.05}}},
        {"viscous_friction": {"damping": {"hinge": 0.05}}},
        {"coulomb_friction": {"torque": {"hinge": 0.03}}},
        {"command_delay": {"delay": 0.01}},
    ],
)
def test_a_first_velocity_does_not_explain_a_missing_effect(robot, effects):
    log, dq = late_rows(robot, effects=effects)
    told = dataclasses.replace(log, dq=np.full_like(log.q, dq))
    assert rms_rad(told) > 20 * NOISE_RAD
    assert rms_rad(log) > 0.95 * rms_rad(told)


def test_a_log_at_rest_is_predicted_as_if_there_were_no_other(robot):
    rest = measured(recording(robot, step(0.3, at_s=0.25), row_rate_hz=200.0), {}, NOISE_RAD)
    moving = late_rows(robot)[0]
    # less than half of them move
    both = Predictor(robot, [rest, moving, rest], threads=1)
    alone = [Predictor(robot, [log], threads=1).predict([PLAIN])[0][0] for log in (rest, moving)]
    together = both.predict([PLAIN])[0][0]
    np.testing.assert_array_equal(together[: len(alone[0])], alone[0])
    moved = together[len(alone[0]) : len(alone[0]) + len(alone[1])]
    np.testing.assert_allclose(moved, alone[1], atol=0.01 * NOISE_RAD)
    still = dataclasses.replace(rest, dq=np.zeros_like(rest.q))
    np.testing.assert_array_equal(alone[0], predicted(still)[0])


def test_a_log_with_no_sample_at_the_beginning_starts_with_its_slope(robot):
    log, _ = late_rows(robot)
    q = log.q.copy()
    q[1:24] = np.nan
    log = dataclasses.replace(log, q=q)
    assert predicted(log, in_motion=True)[1] == pytest.approx(slope_of_motion(log)[0][0])


def beginning(slopes, doubt):
    """Of one recording with a joint for each of `doubt`, and its response to their velocities."""
    k, njoint = slopes.shape
    empty, one = np.zeros((1, 1, njoint)), np.zeros((1, njoint))
    schedule = Schedule(0.001, empty, one, one, one, one, *np.zeros((2, 1), bool), np.arange(1))
    wanted = (np.zeros(k, int), np.arange(k), np.zeros(k, int), np.zeros(k, int))
    made = Beginning(schedule, wanted, np.zeros(k), NOISE_RAD, np.array([doubt]))
    return made, lambda starts: 1e-3 + starts[:, 0, :, 2] @ slopes.T


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=3),
    st.floats(0.0, 1.0),
    st.integers(0, 2**32 - 1),
)
def test_a_step_never_makes_a_linear_response_worse(doubt, response, seed):
    slopes = response * np.random.default_rng(seed).normal(size=(8, len(doubt)))
    if not any(doubt):
        doubt[0] = 0.1
    made, predict = beginning(slopes, doubt)
    found = made.estimate(predict, [], np.zeros((1, 1, len(doubt))))
    before = np.linalg.norm(predict(np.zeros_like(found)))
    assert np.linalg.norm(predict(found)) <= before * (1 + 1e-9)
    assert (np.abs(found[0, 0, :, 2]) <= np.linalg.norm(doubt) * before / NOISE_RAD).all()
    assert (found[..., :2] == 0).all()


def test_a_joint_that_does_not_answer_keeps_its_slope():
    made, predict = beginning(np.zeros((8, 2)), [0.1, 0.2])
    assert (made.estimate(predict, [], np.zeros((1, 1, 2))) == 0).all()


def test_a_step_is_not_taken_where_a_large_velocity_leaps():
    made, _ = beginning(np.ones((8, 1)), [0.1])

    def predict(starts):
        # dry friction stops a joint after a way that grows with the square of its velocity
        v = starts[:, 0, :, 2]
        return np.repeat(0.01 * v + 10 * v**2 - 1e-4, 8, axis=1)

    # where the slope at first, of a difference of 1 mrad/s, would lead
    leap = np.full((1, 1, 1, 3), 1e-4 / 0.02)
    assert np.abs(predict(leap)).max() > 1e-4
    assert np.abs(predict(made.estimate(predict, [], np.zeros((1, 1, 1))))).max() <= 1e-4


def test_a_joint_that_dry_friction_just_holds_stays_though_others_of_the_set_move(robot):
    friction = {"coulomb_friction": {"torque": {"hinge": 0.105}}}
    # 0.1 N·m of the motor, from before the first row
    still = recording(robot, step(0.02, at_s=0.05), kp=5, kd=0.3, row_rate_hz=200.0)
    late = still.time >= 0.1
    time = still.time[late] - 0.1
    for seed in range(5):
        log = measured(still, friction, NOISE_RAD, seed)
        log = dataclasses.replace(log, time=time, q_des=log.q_des[late], q=log.q[late])
        layout, u = Model(robot, friction).vector(log.joints)
        predictor = Predictor(robot, [log], threads=1, in_motion=True)
        q = predictor.predict([Request(layout, u[None])])[0][0]
        # where it stays is measured with noise
        assert np.abs(q).max() < 3 * NOISE_RAD


# a free-running torque on a pendulum, and where it begins in each recording, rad
FREE = {"amplitude": {"hinge": 0.1}, "frequency": {"hinge": 0.7}}
BEGINS = (0.4, 2.5, -1.9)


def begun_at(robot, phases, effects=None, **changes):
    """Recordings of a machine that a torque shakes, whose clock each log begins anew."""
    logs = []
    for seed, (phase, hz) in enumerate(zip(phases, (0.7, 0.9, 1.2), strict=False)):
        torque = {**{k: dict(v) for k, v in FREE.items()}, "phase": {"hinge": phase}}
        made = recording(robot, swing(0.5, hz), f"{seed}", duration_s=2.0, **changes)
        hidden = {"periodic_torque": torque, **(effects or {})}
        logs.append(measured(made, hidden, NOISE_RAD, seed))
    return logs


@pytest.mark.parametrize(
    "others", [{}, {"coulomb_friction": {"torque": {"hinge": 0.05}}}], ids=["alone", "friction"]
)
def test_a_phase_that_is_free_is_told_by_the_first_half_of_each_recording(tmp_path, others):
    logs = begun_at(pendulum(tmp_path), BEGINS, others)
    effects = {"free_running_torque": FREE, **others}
    q = np.concatenate([log.q.ravel() for log in logs])
    error = predict(logs, effects) - q
    assert np.sqrt(np.mean(error**2)) < 1.1 * NOISE_RAD
    # what comes later does not move it
    later = dataclasses.replace(logs[0], q=logs[0].q + 0.1 * (logs[0].time[:, None] > 1.05))
    np.testing.assert_allclose(predict(later, effects), predict(logs[0], effects), atol=1e-9)


def test_each_joint_swings_from_a_phase_of_its_own(tmp_path):
    robot = two_pendulums(tmp_path)
    own = {"amplitude": 0.1, "frequency": 1.3}
    truth = {"phase": {"left": 0.5, "right": -2.0}}
    truth |= {name: dict.fromkeys(truth["phase"], value) for name, value in own.items()}
    commands = lambda t: np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)  # noqa: E731
    made = recording(robot, commands, duration_s=2.0)
    made = measured(made, {"periodic_torque": truth}, NOISE_RAD)
    free = {name: truth[name] for name in own}
    error = predict(made, {"free_running_torque": free}) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 1.1 * NOISE_RAD


def test_a_phase_beside_bristles_that_hold_is_predicted_to_the_noise(tmp_path):
    """The log begins in motion: what the bristles hold is told by its first moments."""
    robot, others = pendulum(tmp_path), {"dahl_friction": BRISTLES}
    (whole,) = begun_at(robot, BEGINS[:1], others, kp=10, kd=0.4, row_rate_hz=200.0)
    rows = whole.time >= 0.5
    part = {"time": whole.time[rows] - 0.5, "q_des": whole.q_des[rows], "q": whole.q[rows]}
    made = dataclasses.replace(whole, **part)
    error = predict(made, {"free_running_torque": FREE, **others}) - made.q.ravel()
    assert np.sqrt(np.mean(error**2)) < 1.15 * NOISE_RAD
