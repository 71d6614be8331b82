"""Planted torques are found again: where they act, what they follow, and their shape."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import FRICTION, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor
from t2l.propose.proposal import LAW, NO_LAW, NOTHING, error_of, propose
from t2l.propose.split import few, split
from tests.diagnose.made import measured, pendulum, recording, swing, two_pendulums

POSITIONS = np.linspace(-2.0, 2.5, 80)


def planted(law, at, torque):
    return Curve(law, tuple(at.tolist()), tuple(torque.tolist()))


def machine(robot, curves, count=2, noise_rad=1e-4, commands=swing, seed=0):
    """Recordings of a robot with curves that its model lacks."""
    model = Model(robot, learned=tuple(curves))
    gains = ((5.0, 0.3, 0.7), (30.0, 1.0, 1.1), (12.0, 0.5, 0.9))[:count]
    made = [
        recording(robot, commands(0.5, hz), f"kp{kp:g}", kp, kd, 1.5, control_rate_hz=500.0)
        for kp, kd, hz in gains
    ]
    return [measured(r, None, noise_rad, seed + i, model) for i, r in enumerate(made)]


def learn(robot, recordings, report=()):
    predictor = Predictor(robot, recordings, threads=1)
    report = predictor.of(report) if report else None
    return propose(Model(robot), predictor, report)


def test_a_smooth_torque_over_position_is_recovered_within_its_band(tmp_path):
    robot = pendulum(tmp_path)
    law = Law(TORQUE, "hinge", "position", "hinge")
    truth = planted(law, POSITIONS, 0.04 * np.sin(5 * POSITIONS) + 0.02 * POSITIONS)
    found = learn(robot, machine(robot, [truth]), machine(robot, [truth], 1, commands=sway, seed=9))
    assert found.verdict == LAW
    (one,) = found.learned
    assert one.curve.law == law
    at = np.array(one.curve.at)
    inside = (one.low <= truth(at)) & (truth(at) <= one.high)
    assert inside.mean() >= 0.9
    assert np.mean(one.high - one.low) < 0.3 * np.ptp(truth(at))
    assert found.report_rmse_rad < 1.5e-4 < 5e-4 < found.report_baseline_rad


def test_a_fast_ripple_gets_more_knots(tmp_path):
    """Six and a half periods are too many for the knots that every law is tried with."""
    robot = pendulum(tmp_path)
    law, at = Law(TORQUE, "hinge", "position", "hinge"), np.linspace(-2.0, 2.5, 600)
    truth = planted(law, at, 0.04 * np.sin(40 * at))
    found = learn(robot, machine(robot, [truth], 3))
    assert [one.curve.law for one in found.learned] == [law]
    assert found.choice_rmse_rad < 1.2 * found.noise_floor_rad < 0.2 * found.choice_baseline_rad


def sway(amplitude, hz):
    return lambda t: 0.2 + amplitude * np.sin(2 * np.pi * 0.8 * hz * t)


def test_velocity_is_told_from_position(tmp_path):
    robot = pendulum(tmp_path)
    speeds = np.linspace(-20.0, 20.0, 40)
    law = Law(TORQUE, "hinge", "velocity", "hinge")
    found = learn(robot, machine(robot, [planted(law, speeds, -0.03 * speeds)]))
    (one,) = found.learned
    assert one.curve.law == law
    slope = np.polyfit(one.curve.at, one.curve.torque, 1)[0]
    assert slope == pytest.approx(-0.03, rel=0.05)


@pytest.mark.slow
def test_dry_friction_is_no_smooth_torque(tmp_path):
    robot = pendulum(tmp_path)
    law = Law(FRICTION, "hinge", "constant", "hinge")
    found = learn(robot, machine(robot, [planted(law, np.array([0.0, 1.0]), np.full(2, 0.05))]))
    (one,) = found.learned
    assert one.curve.law.kind == FRICTION
    assert one.curve.torque[0] == pytest.approx(0.05, rel=0.05)


@pytest.mark.slow
def test_the_joint_is_found(tmp_path):
    robot = two_pendulums(tmp_path)
    law = Law(TORQUE, "right", "position", "right")
    truth = planted(law, POSITIONS, -0.1 * POSITIONS)

    def both(amplitude, hz):
        return lambda t: np.stack([swing(amplitude, hz)(t), swing(0.4, 0.7 * hz)(t)], axis=1)

    found = learn(robot, machine(robot, [truth], commands=both))
    assert [one.curve.law for one in found.learned] == [law]


def test_friction_that_has_a_direction_is_dry_friction_and_a_torque(tmp_path):
    """A curve over the velocity alone explains more than either."""
    robot, ends = pendulum(tmp_path), np.array([0.0, 1.0])
    torque, friction = (Law(kind, "hinge", "constant", "hinge") for kind in (TORQUE, FRICTION))
    truth = [planted(torque, ends, np.full(2, -0.05)), planted(friction, ends, np.full(2, 0.08))]
    found = learn(robot, machine(robot, truth, 3))
    assert {one.curve.law for one in found.learned} == {torque, friction}


def test_noise_gives_no_proposal(tmp_path):
    robot = pendulum(tmp_path)
    found = learn(robot, machine(robot, []))
    assert found.verdict == NOTHING
    assert found.learned == ()


@pytest.mark.slow
def test_what_follows_nothing_gives_no_proposal(tmp_path):
    robot, rng = pendulum(tmp_path), np.random.default_rng(1)
    # each tenth of a second the encoder is off by something else
    jolted = [
        replace(r, q=r.q + 1e-3 * rng.normal(size=(16, 1)).repeat(10, axis=0)[: len(r.q)])
        for r in machine(robot, [])
    ]
    assert learn(robot, jolted).verdict == NO_LAW


def test_a_curve_is_an_effect_of_the_model(tmp_path):
    robot = pendulum(tmp_path)
    law = Law(TORQUE, "hinge", "position", "hinge")
    truth = planted(law, POSITIONS, -0.1 * POSITIONS)
    recordings = machine(robot, [truth])
    predictor = Predictor(robot, recordings, threads=1)
    assert error_of(Model(robot, learned=(truth,)), predictor) == pytest.approx(1e-4, rel=0.15)


def test_of_many_recordings_few_are_taken_over_the_gains(tmp_path):
    robot = pendulum(tmp_path)
    made = [recording(robot, swing(), f"r{kp}", kp, 1.0, 0.3) for kp in (9, 3, 7, 1, 5)]
    whole = Predictor(robot, made, threads=1)
    part, at = few(whole, 3)
    assert [r.kp[0] for r in part.recordings] == [9.0, 1.0, 5.0]
    np.testing.assert_array_equal(part.samples.q, whole.samples.q[at])


def test_both_halves_see_all_of_the_time(tmp_path):
    made = [recording(pendulum(tmp_path), swing(), f"r{i}", duration_s=6.0) for i in range(3)]
    predictor = Predictor(made[0].robot, made, threads=1)
    fitted, chosen = split(predictor)
    assert (fitted ^ chosen).all()
    for half in (fitted, chosen):
        assert set(np.floor(predictor.samples.time[half])) >= set(range(6))
