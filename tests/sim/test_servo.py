import dataclasses

import numpy as np
import pytest
from benchmarks.hidden_effects.cases import ROBOTS
from scipy.integrate import solve_ivp

from t2l.effects.term import Layout
from t2l.identify.prediction import Predictor, Request
from t2l.robots import plant
from t2l.sim import servo
from t2l.sim.schedule import Schedule
from t2l.sim.servo import ServoLoop
from tests.diagnose.made import (
    DAMPING,
    INERTIA,
    WEIGHT,
    hold,
    pendulum,
    predict,
    recording,
    step,
    swing,
)

PERIOD_S = 0.001
GAINS = np.array([[5.0, 0.3], [80.0, 2.0]])


def run(robot, *settings, **named):
    """Position (nrec, ticks + 1) under the same commands at several gains."""
    model = plant.load(robot, ["hinge"]).compile()
    return loop(model, *settings, **named).run()[0][0, :, :, 0]


def loop(model, gains=GAINS, ticks=300, substeps=1, period_s=PERIOD_S, command=None, coarseness=1):
    """The loop that `run` runs."""
    times = np.arange(ticks + 2) * period_s
    command = command or swing(0.6, 2.0)
    n = len(gains)
    schedule = Schedule(
        period_s=period_s,
        commands=np.repeat(command(times)[:, None, None], n, axis=1),
        kp=gains[:, :1],
        kd=gains[:, 1:],
        start_q=np.full((n, 1), 0.3),
        start_dq=np.full((n, 1), 0.5),
        compensated=np.zeros(n, bool),
        balanced=np.zeros(n, bool),
        sample_ticks=np.arange(ticks + 1),
        coarseness=coarseness,
    )
    return ServoLoop(model, ("hinge",), schedule, 1, 1, substeps)


def solved(damping):
    """The pendulum's equation under a torque that is held between ticks."""
    found = np.empty((len(GAINS), 301))
    commands = swing(0.6, 2.0)(np.arange(301) * PERIOD_S)
    for i, (kp, kd) in enumerate(GAINS):
        state = np.array([0.3, 0.5])
        for tick, command in enumerate(commands):
            found[i, tick] = state[0]
            torque = kp * (command - state[0]) - kd * state[1]

            def motion(_, x, torque=torque):
                return x[1], (torque - WEIGHT * np.sin(x[0]) - damping * x[1]) / INERTIA

            state = solve_ivp(motion, (0, PERIOD_S), state, rtol=1e-10, atol=1e-13).y[:, -1]
    return found


@pytest.fixture(scope="module")
def exact():
    return solved(DAMPING)


def test_a_loop_of_1_khz_solves_the_pendulums_equation(tmp_path, exact):
    error = np.abs(run(pendulum(tmp_path)) - exact).max(axis=1)
    assert (error < 5e-5).all(), error


def test_finer_steps_are_better_in_proportion(tmp_path, exact):
    robot = pendulum(tmp_path)
    error = [np.abs(run(robot, substeps=n) - exact).max() for n in (1, 2, 4, 8)]
    assert np.all(np.array(error[1:]) < 0.6 * np.array(error[:-1])), error


def test_without_damping_integration_is_second_order(tmp_path):
    robot, exact = pendulum(tmp_path, 'armature="0.005"'), solved(0.0)
    error = [np.abs(run(robot, substeps=n) - exact).max() for n in (1, 2, 4)]
    assert error[0] < 1e-6
    assert np.all(np.array(error[1:]) < 0.3 * np.array(error[:-1])), error


def test_a_slow_loop_holds_its_torque(tmp_path):
    """At 100 Hz: physics still steps at 1 kHz, and the law is evaluated every 10 ms."""
    period, command = 0.01, 0.9
    kp, kd = GAINS[0]
    q = run(pendulum(tmp_path), GAINS[:1], 40, 1, period, hold(command))[0]
    state, expected = np.array([0.3, 0.5]), []
    for _ in range(41):
        expected.append(state[0])
        torque = kp * (command - state[0]) - kd * state[1]

        def motion(_, x, torque=torque):
            return x[1], (torque - WEIGHT * np.sin(x[0]) - DAMPING * x[1]) / INERTIA

        state = solve_ivp(motion, (0, period), state, rtol=1e-9, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(q, expected, atol=2e-4)


def test_what_acts_on_a_joint_goes_on_between_the_ticks_of_a_slow_loop(tmp_path):
    """At 100 Hz, with a drag that follows the velocity and a motor that fades over time."""
    period, command, (kp, kd) = 0.01, 0.9, GAINS[0]
    drag, fades_s = 0.2, 0.1
    made = loop(
        plant.load(pendulum(tmp_path), ["hinge"]).compile(), GAINS[:1], 40, 1, period, hold(command)
    )

    def fade(tick, torque):
        torque *= np.exp(-made.elapsed_s(tick) / fades_s)

    def add(tick, q, dq, torque):
        torque -= drag * np.abs(dq) * dq

    made.motor_filters.append(fade)
    made.joint_torques.append(add)
    q = made.run()[0][0, 0, :, 0]
    state, expected = np.array([0.3, 0.5]), []
    for tick in range(41):
        expected.append(state[0])
        demand = kp * (command - state[0]) - kd * state[1]

        def motion(t, x, demand=demand, start=tick * period):
            torque = demand * np.exp(-(start + t) / fades_s) - drag * abs(x[1]) * x[1]
            return x[1], (torque - WEIGHT * np.sin(x[0]) - DAMPING * x[1]) / INERTIA

        state = solve_ivp(motion, (0, period), state, rtol=1e-9, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(q, expected, atol=5e-4)


@pytest.mark.parametrize(("coarseness", "less"), [(2, 0.2), (4, 0.3)])
def test_a_coarser_loop_looks_ahead_by_what_it_is_later(tmp_path, exact, coarseness, less):
    robot, ticks, period = pendulum(tmp_path), 300 // coarseness, coarseness * PERIOD_S

    def command(times):
        # what the finer loop commands within a tick, on average
        return swing(0.6, 2.0)(times + (period - PERIOD_S) / 2)

    ahead = run(robot, GAINS, ticks, 1, period, command, coarseness)
    slower = run(robot, GAINS, ticks, 1, period, command)
    at = exact[:, ::coarseness]
    assert np.abs(ahead - at).max() < less * np.abs(slower - at).max()


def test_loops_of_one_model_have_steps_of_their_own(tmp_path):
    model = plant.load(pendulum(tmp_path), ["hinge"]).compile()
    alone = loop(model).run()[0]
    fast, _ = loop(model), loop(model, period_s=0.0007)
    np.testing.assert_array_equal(fast.run()[0], alone)


def test_a_simulation_that_diverges_is_nan_and_leaves_the_others_alone(tmp_path):
    robot = pendulum(tmp_path)
    wild = np.array([[5.0, 1e4], *GAINS, [5.0, 1e4]])
    with np.errstate(all="ignore"):
        q = run(robot, wild)
        alone = run(robot, wild[:1])
    assert np.isnan(q[[0, 3]]).all()
    np.testing.assert_array_equal(q[1:3], run(robot))
    assert np.isnan(alone).all()


ARM = ROBOTS["two_joint_arm"]
HOME = np.array(ARM.home)


def arm_recording(**changes):
    return dataclasses.replace(
        recording(str(ARM.mjcf), lambda t: np.tile(HOME, (len(t), 1))), joints=ARM.joints, **changes
    )


def test_gravity_compensation_holds_an_arm_still():
    q = predict(arm_recording(gravity_compensation=True)).reshape(-1, 2)
    np.testing.assert_allclose(q, np.tile(HOME, (len(q), 1)), atol=1e-9)


def test_compensated_and_uncompensated_recordings_share_a_batch():
    held, sagging = (arm_recording(gravity_compensation=g, name=str(g)) for g in (True, False))
    together = predict([held, sagging])
    np.testing.assert_array_equal(together, np.concatenate([predict(held), predict(sagging)]))
    assert np.abs(together[len(together) // 2 :].reshape(-1, 2) - HOME).max() > 0.05


def test_without_compensation_the_springs_carry_the_weight(tmp_path):
    kp = 20.0
    q = predict(recording(pendulum(tmp_path), hold(0.8), kp=kp, kd=1.5, duration_s=3.0))[-1]
    assert kp * (0.8 - q) == pytest.approx(WEIGHT * np.sin(q), abs=1e-6)


def test_recordings_with_different_rates_are_predicted_together(tmp_path):
    robot = pendulum(tmp_path)
    recordings = [
        recording(robot, swing(), "fast"),
        recording(robot, swing(), "slow", control_rate_hz=200.0, duration_s=0.6),
        recording(robot, swing(), "long", kp=60.0, duration_s=2.0, row_rate_hz=130.0),
    ]
    together = predict(recordings)
    np.testing.assert_array_equal(together, np.concatenate([predict(r) for r in recordings]))


def test_samples_between_ticks_lie_between_them(tmp_path):
    robot = pendulum(tmp_path)
    at_ticks = recording(robot, hold(0.8), row_rate_hz=1000.0, duration_s=0.5)
    q = predict(at_ticks)
    late = at_ticks.time[:-1] + 0.4e-3
    between = dataclasses.replace(
        at_ticks,
        time=np.r_[0.0, late],
        q_des=np.full((len(late) + 1, 1), 0.8),
        q=np.full((len(late) + 1, 1), 0.8),
    )
    found = predict(between)[1:]
    np.testing.assert_allclose(found, 0.6 * q[:-1] + 0.4 * q[1:], atol=3e-5)


def test_rows_without_a_sample_still_command(tmp_path):
    whole = recording(pendulum(tmp_path), swing())
    every_third = np.where(np.arange(len(whole.time))[:, None] % 3 == 0, whole.q, np.nan)
    sparse = dataclasses.replace(whole, q=every_third)
    np.testing.assert_allclose(predict(sparse), predict(whole)[::3], atol=1e-14)


def test_commands_are_held_until_the_next_row(tmp_path):
    """A command that comes between two ticks is heard at the next one."""
    robot = pendulum(tmp_path)
    rows = recording(robot, step(0.5, at_s=0.1), row_rate_hz=1000.0, duration_s=0.5)
    coarse = dataclasses.replace(
        rows,
        time=np.r_[0.0, 0.0993, 0.2, 0.3, 0.5],
        q_des=np.array([[0.0], [0.5], [0.5], [0.5], [0.5]]),
        q=np.zeros((5, 1)),
    )
    np.testing.assert_allclose(predict(coarse)[2:], predict(rows)[[200, 300, 500]], atol=1e-12)


def test_motors_stop_at_the_limits_of_the_mjcf(tmp_path):
    limit = 0.2
    robot = pendulum(
        tmp_path, f'armature="0.005" actuatorfrclimited="true" actuatorfrcrange="-{limit} {limit}"'
    )
    q = predict(recording(robot, hold(1.0), kp=50.0, kd=2.0, duration_s=4.0, q=np.zeros((401, 1))))
    # lifted no further than the limit carries, where unlimited motors reach 0.97 rad
    assert q.max() < 2.1 * np.arcsin(limit / WEIGHT)


def test_a_start_in_motion_is_taken_from_measured_velocity(tmp_path):
    whole = recording(pendulum(tmp_path), swing(), row_rate_hz=1000.0, duration_s=1.0)
    predictor = Predictor(whole.robot, [whole], threads=1)
    (q,), (dq,) = predictor.predict([Request(Layout(()), np.zeros((1, 0)))], velocity=True)
    later = slice(300, None)
    tail = dataclasses.replace(
        whole,
        time=whole.time[later],
        q_des=whole.q_des[later],
        q=q[0][later, None],
        dq=dq[0][later, None],
    )
    np.testing.assert_allclose(predict(tail), q[0][later], atol=1e-9)


def test_without_torque_a_joint_swings_freely(tmp_path):
    made = recording(pendulum(tmp_path), hold(0.8), duration_s=0.6, kp=40.0, kd=1.0)
    on = np.where(made.time < 0.2, 1.0, 0.0)[:, None]
    on[3] = np.nan  # not sampled: as before
    q = predict(dataclasses.replace(made, torque_enabled=on))
    held = predict(made)
    np.testing.assert_array_equal(q[:21], held[:21])

    def free(_, x):
        return x[1], (-WEIGHT * np.sin(x[0]) - DAMPING * x[1]) / INERTIA

    start = [q[20], (held[20] - held[19]) / 0.01]
    swings = solve_ivp(free, (0, 0.4), start, rtol=1e-9, t_eval=np.arange(41) * 0.01).y[0]
    np.testing.assert_allclose(q[20:], swings, atol=5e-3)
    assert abs(q[-1] - held[-1]) > 0.5


def test_what_balances_the_weight_elsewhere_goes_on_without_torque():
    compensated = (True, "continuous")
    made = [arm_recording(gravity_compensation=g, name=str(g)) for g in compensated]
    off = [dataclasses.replace(r, torque_enabled=np.zeros_like(r.q)) for r in made]
    falls, balanced = predict(off).reshape(2, -1, 2)
    np.testing.assert_allclose(balanced, np.tile(HOME, (len(balanced), 1)), atol=1e-9)
    assert np.abs(falls[-1] - HOME).max() > 0.5


def test_what_carries_the_weight_continuously_is_no_later_than_the_weight(monkeypatch):
    def swinging(t):
        return HOME + np.stack([swing(0.5, 0.9)(t), swing(0.6, 1.4)(t)], axis=1)

    made = dataclasses.replace(
        recording(str(ARM.mjcf), swinging, kp=20.0, kd=1.0),
        joints=ARM.joints, gravity_compensation="continuous", control_rate_hz=125.0,
    )  # fmt: skip
    stronger = {"torque_constant": {"factor": dict.fromkeys(ARM.joints, 1.3)}}

    def at(plant_period_s):
        monkeypatch.setattr(servo, "PLANT_PERIOD_S", plant_period_s)
        return predict(made, stronger, substeps=8)

    # late by half a tick, it would be off by 3.5e-4 rad
    assert np.abs(at(8e-3) - at(2.5e-4)).max() < 1e-4
