"""Logs without commanded positions: the simulation is held softly to what was measured."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from t2l.detective.data_split import split
from t2l.detective.explanation import explained
from t2l.detective.search import search
from t2l.diagnose.inverse_dynamics_residual import missing_torque
from t2l.diagnose.ranking import NOTHING_MISSING
from t2l.effects.registry import builtin
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.soft_hold import HOLD_HZ
from t2l.recordings.recording import held
from tests.diagnose.made import DAMPING, INERTIA, WEIGHT, pendulum, predict, recording, swing

NOISE_RAD = 3e-4  # ten times what a step of 1 ms is off by
RATE_HZ = 100.0  # of rows, and of the torques that are commanded
OF_POSITIONS = {
    "controller_gains", "command_delay", "command_filter", "error_clip", "error_dead_band",
    "integral_action", "measurement_delay", "set_point_interpolation", "set_point_profile",
    "velocity_feed_forward", "velocity_filter",
}  # fmt: skip


def moved(torque, seconds, friction=0.0, factor=1.0, powered=lambda t: 1.0):
    """Position and velocity (n,) at the rows, by the pendulum's equation; torque(t, q, dq) is held.

    Returns what was commanded too.
    """
    q, dq, told = [0.2], [0.0], []
    for row in range(round(seconds * RATE_HZ) + 1):
        t = row / RATE_HZ
        told.append(torque(t, q[-1], dq[-1]))
        held = factor * told[-1] * powered(t)

        def motion(_, x, held=held):
            rubs = friction * np.tanh(x[1] / 2e-3) + DAMPING * x[1]
            return x[1], (held - rubs - WEIGHT * np.sin(x[0])) / INERTIA

        end = solve_ivp(motion, (0, 1 / RATE_HZ), (q[-1], dq[-1]), "LSODA", rtol=1e-8, atol=1e-10)
        q.append(end.y[0, -1])
        dq.append(end.y[1, -1])
    return np.array(q[:-1]), np.array(dq[:-1]), np.array(told)


def led(hz, kp=15.0, kd=0.6):
    """A torque that leads the pendulum along a swing, as somebody's own controller would."""
    way = swing(0.5, hz)
    return lambda t, q, dq: kp * (way(t) - q) - kd * dq


def signals(q, **command):
    """(n,) each as a recording has them that no position is commanded of."""
    columns = {name: values[:, None] for name, values in {"q": q, **command}.items()}
    return columns | {"q_des": held(columns["q"])}


def torque_log(robot, hz, seconds=2.0, seed=0, noise=NOISE_RAD, **machine):
    """A recording of commanded torques."""
    q, _, told = moved(led(hz), seconds, **machine)
    noisy = q + noise * np.random.default_rng(seed).normal(size=len(q))
    made = recording(robot, lambda t: 0 * t, f"swing{hz:g}", 0.0, 0.0, seconds, control="torque")
    return dataclasses.replace(made, **signals(noisy, tau_ff=told))


def torque_logs(robot, **machine):
    """Four, of which one reports."""
    return [torque_log(robot, hz, seed=i, **machine) for i, hz in enumerate((0.7, 0.9, 1.1, 0.8))]


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def test_the_right_model_leaves_the_noise(robot):
    made = torque_log(robot, 0.9, seconds=4.0)
    error = predict(made) - made.q[:, 0]
    # the hold follows some of the noise
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.96 * NOISE_RAD, rel=0.05)


def test_a_lacking_torque_shows_as_its_deflection_of_the_hold(robot):
    # commanded 0.04 N·m more than what moves the pendulum, all the time
    made = torque_log(robot, 0.1, seconds=3.0)
    more = dataclasses.replace(made, tau_ff=made.tau_ff + 0.04)
    error = (predict(more) - more.q[:, 0])[len(more.q) // 2 :]
    stiffness = INERTIA * (2 * np.pi * HOLD_HZ) ** 2 + WEIGHT * np.cos(
        made.q[len(made.q) // 2 :, 0]
    )
    assert error == pytest.approx(0.04 / stiffness, rel=0.05, abs=4 * NOISE_RAD)


def test_the_torque_that_is_lacking_is_read_off_through_the_hold(robot):
    made = torque_log(robot, 0.5, seconds=3.0)
    less = dataclasses.replace(made, tau_ff=made.tau_ff - 0.04)
    predictor = Predictor(robot, [less], threads=1)
    error = predictor.samples.q - predict(less)
    found = missing_torque(predictor, error)[100:-50]
    assert np.mean(found) == pytest.approx(0.04, rel=0.05)


@pytest.mark.parametrize(
    ("machine", "name", "parameter", "value", "within"),
    [
        ({"friction": 0.05}, "coulomb_friction", "torque", 0.05, 0.003),
        ({"factor": 0.8}, "torque_constant", "factor", 0.8, 0.01),
    ],
)
def test_what_a_machine_lacks_is_found(robot, machine, name, parameter, value, within):
    found = search(Model(robot), split(robot, torque_logs(robot, **machine), threads=1)).model
    assert set(found.effects) == {name}
    assert found.effects[name][parameter]["hinge"] == pytest.approx(value, abs=within)


def test_where_nothing_is_missing_nothing_is_looked_for(robot):
    found = explained(Model(robot), split(robot, torque_logs(robot), threads=1))
    assert found.verdict == NOTHING_MISSING


def test_no_effect_of_gains_or_positions_is_tried(robot):
    logs = torque_logs(robot)
    barred = {name for name, effect in builtin().items() if not effect.may_act(logs)}
    assert barred >= OF_POSITIONS
    assert not barred & {"coulomb_friction", "torque_constant", "torque_delay", "payload"}
    driven = [dataclasses.replace(log, control="velocity", kd=log.kd + 0.5) for log in logs]
    assert builtin()["controller_gains"].may_act(driven)
    assert not builtin()["set_point_profile"].may_act(driven)


def test_a_motor_that_is_off_leaves_the_hold_on(robot):
    q, _, told = moved(led(0.9), 3.0, powered=lambda t: float(t < 1.5))
    made = torque_log(robot, 0.9, seconds=3.0)
    on = (made.time < 1.5).astype(float)[:, None]
    made = dataclasses.replace(made, **signals(q, tau_ff=told), torque_enabled=on)
    assert np.abs(predict(made) - q).max() < 2e-4
    damped = {"viscous_friction": {"damping": {"hinge": 0.05}}}
    free = dataclasses.replace(made, control="position")
    off = made.time > 2
    held, drifting = (np.abs(predict(r, damped) - q)[off].max() for r in (made, free))
    assert held < 0.3 * drifting


def test_a_gap_in_the_samples_is_not_held_to_anything(robot):
    made = torque_log(robot, 0.9, seconds=3.0, noise=0.0)
    gap = (made.time > 1.0) & (made.time < 1.6)
    q = np.where(gap[:, None], np.nan, made.q)
    error = predict(dataclasses.replace(made, q=q)) - made.q[~gap, 0]
    assert np.abs(error).max() < 2e-4


def test_a_log_of_velocities_is_held_too(robot):
    way = swing(0.5, 0.9)

    def speed(t):
        return np.minimum(t / 0.5, 1.0) ** 2 * (way(t + 5e-3) - way(t - 5e-3)) / 1e-2

    # its loop runs at the rate of the rows
    q, _, _ = moved(lambda t, q, dq: 2.0 * (speed(t) - dq), 3.0)
    made = recording(
        robot, lambda t: 0 * t, "driven", 0.0, 2.0, 3.0, control="velocity", control_rate_hz=RATE_HZ
    )
    made = dataclasses.replace(made, **signals(q, dq_des=speed(made.time)))
    assert np.abs(predict(made) - q).max() < 5e-4


def test_coarse_ticks_hold_as_fine_ones_do(robot):
    made = torque_log(robot, 0.9, friction=0.03)
    layout, u = Model(robot).vector(made.joints)
    fine, coarse = (
        Predictor(robot, [made], threads=1, coarseness=n).predict([Request(layout, u[None])])[0]
        for n in (1, 4)
    )
    assert np.abs(fine - coarse).max() < 3e-4
