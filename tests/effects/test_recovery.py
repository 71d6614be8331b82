"""What was planted is found again, and what physics asks of the effects that robots really have."""

import dataclasses
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.optimize import brentq

from t2l.effects.registry import builtin
from t2l.errors import EffectError
from tests.diagnose.made import (
    DAMPING,
    GRAVITY,
    LENGTH,
    WEIGHT,
    _body,
    _write,
    hold,
    measured,
    pendulum,
    predict,
    recording,
    spinner,
    swing,
    swings,
    two_pendulums,
)
from tests.effects.recovery import recovered

NOISE_RAD = 1e-4
KP = 20.0
SHORT = {"duration_s": 1.2, "control_rate_hz": 250.0}  # a slow loop takes few ticks

# planted on a pendulum, and to what part of each it is found from 2.4 s of motion
PLANTED = {
    "parallel_spring": ({"stiffness": 0.8, "rest": 0.5}, 0.01),
    "base_tilt": ({"pitch": 0.12}, 0.01),
    "integral_action": ({"gain": 12.0, "limit": 0.5}, 0.01),
    "velocity_filter": ({"cutoff": 8.0}, 0.01),
    "error_dead_band": ({"band": 0.008}, 0.02),
    "error_clip": ({"limit": 0.04}, 0.02),
    "torque_dead_zone": ({"zone": 0.1}, 0.02),
    "velocity_feed_forward": ({"factor": 0.6}, 0.01),
    "torque_delay": ({"delay": 0.006}, 0.02),
    "measurement_delay": ({"delay": 0.006}, 0.02),
    "square_root_friction": ({"coefficient": 0.06}, 0.02),
    "torque_ripple_with_position": ({"amplitude": 0.15, "phase": 0.7, "periods": 20.0}, 0.05),
    "set_point_interpolation": ({"ramp": 0.03}, 0.02),
    "set_point_profile": ({"velocity": 1.5, "acceleration": 30.0}, 0.05),
    "encoder_scale": ({"error": 0.03}, 0.02),
    "encoder_eccentricity": ({"amplitude": 0.02, "phase": 0.8}, 0.05),
    "supply_sag": ({"drop": 0.2}, 0.02),
    "directional_friction": ({"forward": 0.08, "backward": 0.03}, 0.02),
    "torque_speed_limit": ({"stall_torque": 1.2, "no_load_speed": 4.0}, 0.01),
    "periodic_torque": ({"amplitude": 0.05, "frequency": 1.7, "phase": 0.4}, 0.05),
    "free_running_torque": ({"amplitude": 0.05, "frequency": 1.7}, 0.05),
    "dahl_friction": ({"coulomb": 0.08, "presliding": 0.01}, 0.02),
    "maxwell_slip_friction": (
        {
            "torque_1": 0.04,
            "radius_1": 0.02,
            "torque_2": 0.05,
            "radius_2": 0.1,
            "torque_3": 0.06,
            "radius_3": 0.4,
        },
        0.05,
    ),
    "friction_drift": ({"at_start": 0.1, "at_end": 0.03, "time_constant": 0.5}, 0.1),
    "torque_constant_drift": ({"at_start": 1.0, "at_end": 0.7, "time_constant": 1.2}, 0.1),
}
ALSO = {"base_tilt": {"roll": 0.0}}
TEMPERATURE = {
    "friction_temperature": ({"torque": 0.06, "per_kelvin": -2e-3}, 0.05),
    "torque_constant_temperature": ({"factor": 0.95, "per_kelvin": -4e-3}, 0.05),
}


def on_the_hinge(name, values):
    shared = {p.name for p in builtin()[name].parameters if not p.per_joint}
    return {name: {k: v if k in shared else {"hinge": v} for k, v in values.items()}}


def check(name, planted, recordings, part):
    found, error = recovered(name, recordings)
    assert error < 1.1 * NOISE_RAD
    for parameter, value in planted.items():
        assert found[parameter] == pytest.approx(value, rel=part), parameter


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_effect_is_found_at_its_values(tmp_path, name):
    values, part = PLANTED[name]
    planted = on_the_hinge(name, {**values, **ALSO.get(name, {})})
    check(name, values, swings(pendulum(tmp_path), planted, NOISE_RAD, **SHORT)[:2], part)


@pytest.mark.parametrize("name", TEMPERATURE)
def test_what_follows_temperature_is_found_from_the_logged_column(tmp_path, name):
    values, part = TEMPERATURE[name]
    made = []
    for start_c in (25.0, 45.0):
        cold = recording(pendulum(tmp_path), swing(0.5, 0.9), kp=10.0, kd=0.5, **SHORT)
        warm = start_c + 10 * cold.time[:, None]
        warm = dataclasses.replace(cold, temperature=warm)
        made.append(measured(warm, on_the_hinge(name, values), NOISE_RAD))
    assert builtin()[name].may_act(made)
    check(name, values, made, part)


@pytest.mark.parametrize("compensation", [True, "continuous"])
def test_a_wrong_compensation_is_found_where_there_is_one(tmp_path, compensation):
    planted = on_the_hinge("gravity_compensation_error", {"factor": 0.85})
    changes = SHORT | {"gravity_compensation": compensation}
    made = swings(pendulum(tmp_path), planted, NOISE_RAD, **changes)[:2]
    check("gravity_compensation_error", {"factor": 0.85}, made, 0.01)
    effect = builtin()["gravity_compensation_error"]
    assert effect.may_act(made)
    assert not effect.may_act(swings(pendulum(tmp_path), {}, **SHORT)[:1])


def test_what_follows_a_column_is_not_tried_without_it(tmp_path):
    made = recording(pendulum(tmp_path), swing())
    effect = builtin()["friction_temperature"]
    assert not effect.may_act([made])
    assert not builtin()["joint_coupling"].may_act([made])
    with pytest.raises(EffectError, match=r"friction_temperature.*temperature"):
        predict(made, on_the_hinge("friction_temperature", TEMPERATURE["friction_temperature"][0]))


def test_a_coupling_is_found_on_the_joint_that_has_it(tmp_path):
    robot = two_pendulums(tmp_path)
    truth = {"stiffness": 0.6, "damping": 0.02, "ratio": 0.7, "rest": 0.3, "before": 1.0}
    planted = {"joint_coupling": {k: {"right": v} for k, v in truth.items()}}

    def both(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    made = [
        measured(recording(robot, both, f"{kp}", kp, kd, **SHORT), planted, NOISE_RAD)
        for kp, kd in ((10.0, 0.5), (60.0, 1.5))
    ]
    found, error = recovered("joint_coupling", made, joints=(1,))
    assert error < 1.1 * NOISE_RAD
    assert {k: v[0] for k, v in found.items()} == pytest.approx(truth, rel=0.03)


def test_a_cable_passes_a_joint_by(tmp_path):
    """Of three pendulums the middle one feels nothing of a cable from the last to the first."""
    names = ("left", "middle", "right")
    bodies = [_body(name, x=float(i), site=f"on_{name}") for i, name in enumerate(names)]
    three = _write(tmp_path, "three", *bodies)
    values = {"stiffness": 2.0, "damping": 0.1, "ratio": 0.7, "rest": 0.3}

    def coupled(robot, joints, before):
        made = recording(robot, lambda t: np.stack([swing()(t)] * 2, axis=1))
        n = len(joints)
        made = dataclasses.replace(
            made, joints=joints, kp=np.full(n, KP), kd=np.full(n, 0.8),
            q=np.repeat(made.q[:, :1], n, axis=1), q_des=np.repeat(made.q_des[:, :1], n, axis=1),
        )  # fmt: skip
        cable = {name: {"right": value} for name, value in {**values, "before": before}.items()}
        return [
            predict(made, effects).reshape(made.q.shape)
            for effects in ({"joint_coupling": cable}, {})
        ]

    two = _write(tmp_path, "two", bodies[0], bodies[2])
    far, free = coupled(three, names, 2.0)
    near, _ = coupled(two, ("left", "right"), 1.0)
    np.testing.assert_allclose(far[:, [0, 2]], near, atol=1e-12)
    np.testing.assert_array_equal(far[:, 1], free[:, 1])
    assert np.abs(far - free)[:, [0, 2]].max(axis=0).min() > 0.01


def test_lugre_friction_is_found_by_what_it_does(tmp_path):
    """Its five numbers are not all told by a short log; its friction is."""
    values = {
        "coulomb": 0.05, "extra_at_rest": 0.06, "velocity": 0.3, "presliding": 0.005,
        "damping": 0.1,
    }  # fmt: skip
    planted = on_the_hinge("lugre_friction", values)
    found, error = recovered("lugre_friction", swings(pendulum(tmp_path), planted, **SHORT)[:1])
    assert error < 1.1 * NOISE_RAD
    assert found["coulomb"] == pytest.approx(0.05, rel=0.1)


# ------------------------------------------------------------------------------- what physics asks


def at_rest(robot, effects, command=0.8, **changes):
    made = recording(
        robot, hold(command), kp=KP, kd=1.5, duration_s=2.0, control_rate_hz=500.0, **changes
    )
    return predict(made, effects)[-1]


def test_a_spring_pulls_a_joint_to_its_rest(tmp_path):
    spring = on_the_hinge("parallel_spring", {"stiffness": 5.0, "rest": -0.2})
    q = at_rest(spinner(tmp_path), spring)
    assert q == pytest.approx((KP * 0.8 + 5.0 * -0.2) / (KP + 5.0), abs=1e-6)


def test_two_springs_add_up(tmp_path):
    own = 'armature="0.005" damping="0.02" stiffness="3" springref="0.4"'
    spring = on_the_hinge("parallel_spring", {"stiffness": 5.0, "rest": -0.2})
    q = at_rest(spinner(tmp_path, own), spring)
    expected = (KP * 0.8 + 3.0 * 0.4 + 5.0 * -0.2) / (KP + 8.0)
    assert q == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("compensation", "carried"), [(False, 0), (True, 1), ("continuous", 1)])
def test_a_leaning_base_turns_the_weight_and_no_compensation_knows(tmp_path, compensation, carried):
    tilt = {"base_tilt": {"roll": 0.0, "pitch": 0.1}}
    q = at_rest(pendulum(tmp_path), tilt, gravity_compensation=compensation)
    # a base that leans by +pitch about y carries the pendulum with it
    load = brentq(lambda q: KP * (0.8 - q) - WEIGHT * (np.sin(q + 0.1) - carried * np.sin(q)), 0, 1)
    assert q == pytest.approx(load, abs=1e-6)


@pytest.mark.parametrize("compensation", [True, "continuous"])
def test_no_compensation_knows_a_link_that_is_heavier(tmp_path, compensation):
    values = {"mass_factor": 1.4, "com_x": 0.0, "com_y": 0.0, "com_z": -0.05, "inertia_factor": 1.0}
    q = at_rest(
        pendulum(tmp_path), on_the_hinge("link_inertia", values), gravity_compensation=compensation
    )
    more = 1.4 * WEIGHT * (LENGTH + 0.05) / LENGTH - WEIGHT
    assert KP * (0.8 - q) == pytest.approx(more * np.sin(q), abs=1e-6)


@pytest.mark.parametrize("compensation", [True, "continuous"])
def test_a_weak_motor_gives_its_part_of_the_weight_that_the_model_has(tmp_path, compensation):
    values = {"mass_factor": 1.4, "com_x": 0.0, "com_y": 0.0, "com_z": 0.0, "inertia_factor": 1.0}
    effects = on_the_hinge("link_inertia", values) | on_the_hinge(
        "torque_constant", {"factor": 0.8}
    )
    q = at_rest(pendulum(tmp_path), effects, gravity_compensation=compensation)
    given = 0.8 * (KP * (0.8 - q) + WEIGHT * np.sin(q))
    assert given == pytest.approx(1.4 * WEIGHT * np.sin(q), abs=1e-6)


def test_every_link_within_the_bounds_is_a_body_that_can_exist(tmp_path):
    """The pseudo-inertia stays positive definite in all corners of the bounds."""
    effect = builtin()["link_inertia"]
    model = mujoco.MjModel.from_xml_path(pendulum(tmp_path))
    rng = np.random.default_rng(0)
    for _ in range(50):
        ends = {p.name: rng.choice([p.lower, p.upper]) for p in effect.parameters}
        mass = model.body_mass[1] * ends["mass_factor"]
        about_com = model.body_inertia[1] * ends["mass_factor"] * ends["inertia_factor"]
        centre = model.body_ipos[1] + [ends[f"com_{axis}"] for axis in "xyz"]
        second = np.diag(0.5 * about_com.sum() - about_com) + mass * np.outer(centre, centre)
        first = mass * centre
        pseudo = np.block([[second, first[:, None]], [first[None], mass]])
        assert np.linalg.eigvalsh(pseudo).min() > 0


def test_an_integrator_leaves_no_lasting_error_until_it_is_clamped(tmp_path):
    robot = pendulum(tmp_path)
    enough = on_the_hinge("integral_action", {"gain": 60.0, "limit": 2.0})
    little = on_the_hinge("integral_action", {"gain": 60.0, "limit": 0.4})
    assert at_rest(robot, enough) == pytest.approx(0.8, abs=1e-4)
    q = at_rest(robot, little)
    assert KP * (0.8 - q) + 0.4 == pytest.approx(WEIGHT * np.sin(q), abs=1e-3)


def test_an_integrator_begins_with_what_holds_a_joint_whatever_acts_on_it(tmp_path):
    """Whoever logs a robot at rest under such a controller sees it at rest."""
    left, right = ({"left": one, "right": two} for one, two in ((0.3, -0.2), (1.2, 0.7)))
    others = {
        "joint_coupling": {
            "stiffness": {"right": 2.0}, "damping": {"right": 0.1}, "ratio": {"right": 0.5},
            "rest": {"right": 0.4}, "before": {"right": 1.0},
        },
        "torque_offset": {"torque": left}, "torque_constant": {"factor": right},
        "cogging": {"amplitude": left, "phase": left, "periods": {"left": 7.0, "right": 7.0}},
        "torque_dead_zone": {"zone": {"left": 0.1, "right": 0.0}},
    }  # fmt: skip
    integral = {"gain": {"left": 60.0, "right": 40.0}, "limit": {"left": 9.0, "right": 9.0}}
    pose = np.array([0.8, -0.3])
    made = recording(two_pendulums(tmp_path), lambda t: np.tile(pose, (len(t), 1)), kp=KP)
    found = predict(made, others | {"integral_action": integral}).reshape(made.q.shape)
    np.testing.assert_allclose(found, np.tile(pose, (len(found), 1)), atol=1e-6)


def test_below_its_level_dahl_friction_is_a_spring(tmp_path):
    """A push far below Fc bends the bristles by what the first stiffness Fc / δ says."""
    bristles = on_the_hinge("dahl_friction", {"coulomb": 1.0, "presliding": 0.01})
    made = recording(spinner(tmp_path), lambda t: 0.005 * t, kp=KP, kd=0.1, row_rate_hz=1000.0)
    q = predict(made, bristles)[-1]
    push = KP * (0.005 - q)
    assert q == pytest.approx(-0.01 * np.log(1 - push), rel=0.02)


def test_bristles_that_are_stiffer_than_a_physics_step_resolves_converge_with_it(tmp_path):
    stiff = on_the_hinge("dahl_friction", {"coulomb": 0.1, "presliding": 1e-5})
    made = recording(pendulum(tmp_path), swing(), duration_s=1.0)
    fine = predict(made, stiff, substeps=8)
    error = [np.abs(predict(made, stiff, substeps=n) - fine).max() for n in (1, 2, 4)]
    assert error[0] < 5e-5
    # of second order
    assert error[1] < error[0] / 3
    assert error[2] < error[1] / 3


def test_a_payload_leaves_its_start_on_a_body_whose_frame_is_at_the_pivot(tmp_path):
    """A mass at the pivot does nothing: the fit begins where it does."""
    robot = tmp_path / "bare.xml"
    text = Path(pendulum(tmp_path)).read_text()
    robot.write_text(text.replace("attachment_site", "nothing"))
    payload = {"payload": {"mass": 0.2, "com_x": 0.0, "com_y": 0.0, "com_z": -0.3}}
    found, error = recovered("payload", swings(str(robot), payload, NOISE_RAD, **SHORT)[:2])
    assert error < 1.1 * NOISE_RAD
    torque = found["mass"] * GRAVITY * np.hypot(found["com_x"], found["com_z"])
    assert torque == pytest.approx(0.2 * GRAVITY * 0.3, rel=0.02)


@pytest.mark.parametrize("compensation", [True, "continuous"])
def test_a_wrong_compensation_leaves_its_part_of_the_weight(tmp_path, compensation):
    wrong = on_the_hinge("gravity_compensation_error", {"factor": 0.7})
    q = at_rest(pendulum(tmp_path), wrong, gravity_compensation=compensation)
    assert KP * (0.8 - q) == pytest.approx(0.3 * WEIGHT * np.sin(q), abs=1e-6)


def test_a_dead_band_and_a_dead_zone_take_their_part_of_the_springs_torque(tmp_path):
    robot, band, zone = pendulum(tmp_path), 0.01, 0.15
    q = at_rest(robot, on_the_hinge("error_dead_band", {"band": band}))
    assert KP * (0.8 - q - band) == pytest.approx(WEIGHT * np.sin(q), abs=1e-6)
    q = at_rest(robot, on_the_hinge("torque_dead_zone", {"zone": zone}))
    assert KP * (0.8 - q) - zone == pytest.approx(WEIGHT * np.sin(q), abs=1e-6)


def test_a_clipped_error_is_a_saturated_spring(tmp_path):
    """At rest at most Kp L holds the arm: it hangs where that is its weight."""
    made = recording(pendulum(tmp_path), hold(0.8), kp=KP, kd=1.5, duration_s=20.0)
    q = predict(made, on_the_hinge("error_clip", {"limit": 0.02}))[-1]
    assert WEIGHT * np.sin(q) == pytest.approx(KP * 0.02, abs=1e-4)


def test_full_feed_forward_leaves_a_ramp_only_its_friction(tmp_path):
    """Kd (q̇_des − q̇) is zero in steady motion, which leaves the damper of the MJCF."""
    made = recording(
        spinner(tmp_path), lambda t: 0.6 * t, kp=KP, kd=1.0, duration_s=1.5, row_rate_hz=1000.0
    )
    q = predict(made, {"velocity_feed_forward": {"factor": 1.0}})
    assert KP * (made.q_des[-1, 0] - q[-1]) == pytest.approx(DAMPING * 0.6, rel=1e-3)


def test_feed_forward_is_the_difference_of_commands_over_their_period(tmp_path):
    """Commands of 50 Hz: the torque of each step is held for the 20 ms to the next."""
    robot, f, kd = pendulum(tmp_path), 0.7, 0.8
    made = recording(robot, swing(), row_rate_hz=50.0, kp=KP, kd=kd)
    q = predict(made, {"velocity_feed_forward": {"factor": f}})
    step = np.diff(made.q_des, axis=0, prepend=made.q_des[:1])
    more = dataclasses.replace(made, q_des=made.q_des + f * kd * step / (0.02 * KP))
    np.testing.assert_allclose(q, predict(more), atol=1e-9)


def test_a_ramp_over_the_command_period_is_the_line_between_commands(tmp_path):
    robot = pendulum(tmp_path)
    held = recording(robot, swing(), row_rate_hz=50.0)
    fine = recording(robot, swing(), row_rate_hz=1000.0)
    # the ramp to a command begins with the tick at which it arrives
    line = np.interp(fine.time + 0.001 - 0.02, held.time, held.q_des[:, 0])[:, None]
    expected = predict(dataclasses.replace(fine, q_des=line))[::20]
    q = predict(held, {"set_point_interpolation": {"ramp": 0.02}})
    np.testing.assert_allclose(q, expected, atol=1e-9)


def test_a_profile_is_a_trapezoid(tmp_path):
    """Up in v/a, then at v, down in v/a; what its ticks are off by halves with the tick."""
    robot, v, a, size = spinner(tmp_path), 1.0, 5.0, 0.6
    profile = on_the_hinge("set_point_profile", {"velocity": v, "acceleration": a})

    def error(rate):
        made = recording(robot, hold(0.0), row_rate_hz=rate, control_rate_hz=rate)
        step = np.where(made.time >= 0.1, size, 0.0)[:, None]
        since = np.clip(made.time - 0.1, 0.0, size / v + v / a)
        left = size / v + v / a - since
        up, down = 0.5 * a * since**2, size - 0.5 * a * left**2
        even = v * since - 0.5 * v**2 / a
        trapezoid = np.where(since < v / a, up, np.where(left < v / a, down, even))[:, None]
        expected = predict(dataclasses.replace(made, q_des=trapezoid))
        return np.abs(predict(dataclasses.replace(made, q_des=step), profile) - expected).max()

    assert error(500.0) < 0.01 * size
    assert error(1000.0) == pytest.approx(0.5 * error(500.0), rel=0.1)
    assert error(2000.0) == pytest.approx(0.25 * error(500.0), rel=0.1)


@pytest.mark.parametrize("name", ["torque_delay", "measurement_delay"])
def test_a_delay_in_the_loop_takes_damping_and_inertia_from_it(tmp_path, name):
    """To first order a delay d takes Kp d from the damping and Kd d from the inertia."""
    kp, kd = 20.0, 0.5
    made = recording(spinner(tmp_path), hold(0.3), kp=kp, kd=kd, row_rate_hz=500.0)
    made = dataclasses.replace(made, q=np.zeros_like(made.q))

    def beyond_first_order(delay):
        less = dataclasses.replace(made, kd=made.kd - kp * delay)
        expected = predict(less, on_the_hinge("armature", {"inertia": -kd * delay}))
        change = np.abs(expected - predict(made)).max()
        return np.abs(predict(made, {name: {"delay": delay}}) - expected).max() / change

    assert beyond_first_order(0.002) < 0.2
    assert beyond_first_order(0.001) == pytest.approx(0.5 * beyond_first_order(0.002), rel=0.15)


def test_a_supply_that_sags_gives_each_joint_less_the_more_the_other_works(tmp_path):
    drop, robot = 0.3, two_pendulums(tmp_path)

    def left_q(right):
        def both(t):
            return np.tile([0.5, right], (len(t), 1))

        made = recording(robot, both, kp=KP, kd=1.5, duration_s=2.0)
        return predict(made, {"supply_sag": {"drop": drop}}).reshape(-1, 2)[-1]

    for right in (0.0, 1.2):
        q = left_q(right)
        spring = KP * (np.array([0.5, right]) - q)
        given = spring / (1 + drop * np.abs(spring).sum())
        # dry friction of 0.01 N·m may hold them a little aside
        np.testing.assert_allclose(given, WEIGHT * np.sin(q), atol=0.011)
    assert left_q(1.2)[0] < left_q(0.0)[0] - 1e-3


def test_an_encoder_that_counts_too_much_stops_the_joint_short(tmp_path):
    """The reading reaches the command: the true motion, which gravity tells, is less."""
    scale = 0.1
    made = recording(pendulum(tmp_path), hold(0.8), kp=KP, kd=1.5, duration_s=2.0)
    made = dataclasses.replace(made, q=np.full_like(made.q, 0.2))
    q = predict(made, on_the_hinge("encoder_scale", {"error": scale}))[-1]
    true = 0.2 + (q - 0.2) / (1 + scale)
    assert KP * (0.8 - q) == pytest.approx(WEIGHT * np.sin(true), abs=1e-4)


def test_an_eccentric_encoder_reads_the_start_that_was_measured(tmp_path):
    a, phase = 0.05, 0.6
    effect = on_the_hinge("encoder_eccentricity", {"amplitude": a, "phase": phase})
    made = recording(pendulum(tmp_path), hold(0.8), kp=KP, kd=1.5, duration_s=2.0)
    q = predict(made, effect)
    true = brentq(lambda x: x + a * np.sin(x + phase) - q[-1], 0, 1)
    assert q[0] == pytest.approx(0.8, abs=1e-9)
    assert KP * (0.8 - q[-1]) == pytest.approx(WEIGHT * np.sin(true), abs=1e-5)
