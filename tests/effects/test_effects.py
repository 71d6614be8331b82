"""Each effect against the plain plant, and against physics written down here."""

import dataclasses
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from t2l.effects.effect import Effect, Parameter, within
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import scales
from tests.diagnose.made import (
    ARMATURE,
    DAMPING,
    GRAVITY,
    INERTIA,
    LENGTH,
    LINK,
    WEIGHT,
    hold,
    measured,
    pendulum,
    predict,
    ramp,
    recording,
    spinner,
    step,
    swing,
    two_pendulums,
)

NAMES = sorted(builtin())

# Values where "absent" is a limit that the bounds keep away from, and how near that comes [rad].
ALMOST_ABSENT = {
    "actuator_bandwidth": ({"cutoff": 500.0}, 2e-3),
    "backlash": (
        {"play": 1e-4, "contact_time": 5e-4, "contact_damping": 0.5, "encoder_on_link": 0.0},
        5e-4,
    ),
    "command_filter": ({"cutoff": 300.0}, 2e-3),
    "joint_flexibility": ({"stiffness": 2e3, "damping": 1.0, "encoder_on_link": 0.0}, 2e-3),
    "set_point_profile": ({"velocity": 1e3, "acceleration": 1e6}, 2e-3),
    "velocity_filter": ({"cutoff": 500.0}, 1e-3),
    "payload": ({"mass": 0.0, "com_x": 0.0, "com_y": 0.0, "com_z": 0.0}, 1e-6),
}


def layout(effect, joints=1):
    return Layout([Term(effect, tuple(range(joints)))])


def absent(effect):
    """Parameters (n,) at which the effect is absent, inside the bounds."""
    if effect.name in ALMOST_ABSENT:
        return {k: np.array([v]) for k, v in ALMOST_ABSENT[effect.name][0].items()}
    neutral = {p.name: 0.0 if np.isnan(p.neutral) else p.neutral for p in effect.parameters}
    return {p.name: np.clip([neutral[p.name]], p.lower, p.upper) for p in effect.parameters}


@pytest.fixture(scope="module")
def pendulums(tmp_path_factory):
    """Two recordings of two joints, both with armature, friction and damping of their own."""
    robot = two_pendulums(tmp_path_factory.mktemp("robot"))

    def both(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    recordings = [
        recording(robot, both, "soft", 10.0, 0.5, 0.5),
        recording(robot, both, "stiff", 60.0, 1.5, 0.4, gravity_compensation=True),
    ]
    recordings = [dataclasses.replace(r, temperature=np.full_like(r.q, 40.0)) for r in recordings]
    return Predictor(robot, [measured(r) for r in recordings], threads=2)


@pytest.fixture(scope="module")
def plain(pendulums):
    return pendulums.predict([Request(Layout(()), np.zeros((1, 0)))])[0][0]


@pytest.fixture(scope="module")
def guesses(pendulums):
    """For every effect a request of its first guesses on both joints."""
    requests = {}
    for name, effect in builtin().items():
        lay = layout(effect, 2)
        starts = effect.starts(scales(pendulums))
        chosen = starts[:: max(1, len(starts) // 8)]
        requests[name] = Request(lay, np.array([lay.encode({name: s}) for s in chosen]))
    return requests


def strong(request):
    """(1, n) u of the last guess; of torque saturation one that leaves the joint some motion."""
    saturates = request.layout.terms[0].effect.name == "torque_saturation"
    return request.u[[4 if saturates else -1]]


@pytest.fixture(scope="module")
def alone(pendulums, guesses):
    """Each effect at its `strong` guess."""
    found = pendulums.predict([Request(r.layout, strong(r)) for r in guesses.values()])
    return dict(zip(guesses, found, strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_at_its_neutral_value_an_effect_changes_nothing(pendulums, plain, name):
    sizes = scales(pendulums)
    effect = within(builtin()[name], sizes.plant, sizes.joints, sizes)
    lay = layout(effect, 2)
    u = lay.encode({name: absent(effect)})
    q = pendulums.predict([Request(lay, u[None])])[0][0]
    np.testing.assert_allclose(q, plain, atol=ALMOST_ABSENT.get(name, (None, 1e-9))[1])


@pytest.mark.parametrize("name", NAMES)
def test_every_first_guess_is_felt(pendulums, plain, guesses, name):
    q = pendulums.predict([guesses[name]])[0]
    assert np.isfinite(q).all()
    change = np.abs(q - plain)
    for joint in range(2):
        felt = change[:, pendulums.samples.joint == joint].max(axis=1)
        # a payload hangs on the last joint, which does not move the first; neither swings about x
        if name == "base_tilt":
            assert (felt > 1e-6).all()
        elif (name, joint) != ("payload", 0):
            assert (felt > 1e-5).all(), (joint, felt)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", NAMES)
def test_beside_any_other_effect_both_are_felt(pendulums, guesses, alone, name):
    """No effect overwrites what another one wrote, whichever comes first."""
    each = {n: r.layout.decode(strong(r))[n] for n, r in guesses.items()}
    each = {n: {p: value[0] for p, value in values.items()} for n, values in each.items()}
    terms = {n: r.layout.terms[0] for n, r in guesses.items()}

    def comes_first(other):
        """A layout puts effects of another order in theirs, and keeps the rest as they are."""
        return other != name and terms[name].effect.order <= terms[other].effect.order

    others = [other for other in NAMES if comes_first(other)]
    requests = []
    for other in others:
        both = Layout([terms[name], terms[other]])
        requests.append(Request(both, both.encode(each)[None]))
    for other, q in zip(others, pendulums.predict(requests), strict=True):
        assert np.isfinite(q).all(), other
        assert np.abs(q - alone[name]).max() > 1e-6, other
        assert np.abs(q - alone[other]).max() > 1e-6, other


class Bias(Effect):
    """q_des → q_des + b, as a user might write it: of no order of its own."""

    name = title = "bias"
    parameters = (Parameter("bias", "rad", -1.0, 1.0, "b", per_joint=False),)
    summary = signature = source = "a bias"

    def install(self, loop, rows, joints, values):
        def change(tick, target):
            target[rows, joints] += values["bias"]

        loop.command_filters.append(change)

    def starts(self, scales):
        return [{"bias": np.array([0.1])}]


@pytest.mark.parametrize("name", NAMES)
def test_no_effect_loses_what_one_before_it_did_to_the_commands(pendulums, guesses, name):
    """After a bias it does what it does to commands that were recorded with the bias."""
    term, values = guesses[name].layout.terms[0], guesses[name].layout.decode(guesses[name].u[-1:])
    both = Layout([Term(Bias(), (0, 1)), term])
    first = {p: value[0] for p, value in values[name].items()}
    u = both.encode({"bias": {"bias": np.array([0.05])}, name: first})
    biased = [dataclasses.replace(r, q_des=r.q_des + 0.05) for r in pendulums.recordings]
    expected = pendulums.of(biased).predict([Request(guesses[name].layout, guesses[name].u[-1:])])
    found = pendulums.predict([Request(both, u[None])])
    np.testing.assert_allclose(found[0], expected[0], atol=1e-6)


def test_variants_in_one_batch_do_not_feel_each_other(pendulums, guesses):
    together = pendulums.predict([Request(r.layout, r.u[:2]) for r in guesses.values()])
    for (name, request), q in zip(guesses.items(), together, strict=True):
        alone = pendulums.predict([Request(request.layout, request.u[len(q) - 1 : len(q)])])[0]
        np.testing.assert_allclose(q[-1], alone[0], atol=1e-12, err_msg=name)


@pytest.mark.parametrize("name", NAMES)
def test_a_joint_without_the_effect_does_not_feel_it(pendulums, plain, guesses, name):
    if name in ("base_tilt", "joint_coupling"):
        pytest.skip("it acts on several joints by its nature")
    effect = builtin()[name]
    lay = Layout([Term(effect, (0,))])
    start = effect.starts(scales(pendulums))[0]
    values = {k: np.asarray(v)[:1] for k, v in start.items()}
    q = pendulums.predict([Request(lay, lay.encode({name: values})[None])])[0][0]
    left = pendulums.samples.joint == 0
    assert np.abs(q - plain)[left].max() > 1e-5
    # an extended model steps twice as finely
    atol = 1e-4 if effect.extends else 1e-9
    np.testing.assert_allclose(q[~left], plain[~left], atol=atol)


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_says_everything_that_reports_print(name):
    effect = builtin()[name]
    assert effect.name == name
    assert {p.name for p in effect.parameters if p.log and p.lower <= 0} == set()
    for other in effect.contains:
        assert other in builtin()
    for text in (effect.title, effect.summary, effect.signature, effect.source):
        assert text
        assert not text.endswith(".")


# ----------------------------------------------------------------------------- loads at rest

KP = 20.0


def at_rest(robot, effects, command=0.8, kp=KP, gravity_compensation=False):
    """Where the joint comes to rest; started near there, so that nothing slides."""
    made = recording(robot, hold(command), kp=kp, kd=1.5, duration_s=1.7)
    made = dataclasses.replace(made, gravity_compensation=gravity_compensation)
    return predict(made, effects)[-1]


def test_a_torque_offset_sags_by_torque_over_stiffness(tmp_path):
    q = at_rest(pendulum(tmp_path), {"torque_offset": {"torque": {"hinge": -0.3}}}, 0.8, KP, True)
    assert q - 0.8 == pytest.approx(-0.3 / KP, abs=1e-9)


@pytest.mark.parametrize("com_x", [0.0, 0.05])
def test_a_payload_is_carried_by_the_springs_alone(tmp_path, com_x):
    mass = 0.2
    payload = {"mass": mass, "com_x": com_x, "com_y": 0.0, "com_z": -0.03}
    q = at_rest(pendulum(tmp_path), {"payload": payload}, 0.8, KP, True)
    lever = (LENGTH + 0.03) * np.sin(q) - com_x * np.cos(q)
    assert KP * (0.8 - q) == pytest.approx(mass * GRAVITY * lever, abs=1e-6)


def test_without_compensation_payload_and_arm_weigh_together(tmp_path):
    payload = {"mass": 0.2, "com_x": 0.0, "com_y": 0.0, "com_z": 0.0}
    q = at_rest(pendulum(tmp_path), {"payload": payload})
    assert KP * (0.8 - q) == pytest.approx((WEIGHT + 0.2 * GRAVITY * LENGTH) * np.sin(q), abs=1e-6)


def test_a_payload_on_the_last_axis_starts_where_it_moves_the_joint(tmp_path):
    robot = tmp_path / "bare.xml"
    robot.write_text(Path(pendulum(tmp_path)).read_text().replace("attachment_site", "pivot"))
    made = measured(recording(str(robot), swing()))
    predictor = Predictor(str(robot), [made], threads=1)
    payload = builtin()["payload"]
    lay = layout(payload)
    starts = payload.starts(scales(predictor))
    q = predictor.predict([Request(lay, np.array([lay.encode({"payload": s}) for s in starts]))])[0]
    assert (np.abs(q - made.q.ravel()).max(axis=1) > 1e-3).all()
    assert max(s["mass"][0] for s in starts) > 10 * min(s["mass"][0] for s in starts)


def test_no_fit_takes_away_more_than_the_robot_has(tmp_path):
    model = Model(two_pendulums(tmp_path))
    known = model.known_effects(("left", "right"))
    has = {"armature": ARMATURE, "viscous_friction": DAMPING, "coulomb_friction": 0.01}
    for name, own in has.items():
        lay = layout(known[name], 2)
        np.testing.assert_allclose(lay.lower, [-own, -own])
        assert lay.encode({name: {known[name].parameters[0].name: np.array([-9.0])}})[0] == -own
    # values of a model file of before stay within it too
    adopted = Model(model.robot, {"armature": {"inertia": {"left": -0.45}}})
    assert adopted.vector(("left", "right"))[1] == [-ARMATURE]


def test_an_encoder_offset_moves_the_gravity_equilibrium(tmp_path):
    offset = 0.07
    q = at_rest(pendulum(tmp_path), {"encoder_offset": {"offset": {"hinge": offset}}})
    assert KP * (0.8 - q) == pytest.approx(WEIGHT * np.sin(q - offset), abs=1e-6)
    # and the compensation, which is that of the true pose, keeps it where it is
    q = at_rest(
        pendulum(tmp_path), {"encoder_offset": {"offset": {"hinge": offset}}}, 0.8, KP, True
    )
    assert q == pytest.approx(0.8, abs=1e-9)


def test_cogging_is_in_balance_with_the_springs(tmp_path):
    a, phase, n = 0.25, -0.6, 12.0
    cogging = {"amplitude": {"hinge": a}, "phase": {"hinge": phase}, "periods": {"hinge": n}}
    q = at_rest(spinner(tmp_path), {"cogging": cogging})
    ripple = a * np.sin(n * q + phase)
    assert KP * (q - 0.8) == pytest.approx(ripple, abs=1e-6)


def test_a_wrong_torque_constant_scales_what_compensates_gravity(tmp_path):
    k = 0.8
    effects = {"torque_constant": {"factor": {"hinge": k}}}
    q = at_rest(pendulum(tmp_path), effects, 0.8, KP, True)
    assert k * KP * (0.8 - q) == pytest.approx((1 - k) * WEIGHT * np.sin(q), abs=1e-6)


def backlash(play, link, contact_time=1e-3, damping=0.3):
    joint = {"play": play, "contact_time": contact_time, "contact_damping": damping}
    values = {name: {"hinge": value} for name, value in joint.items()}
    return {"backlash": values | {"encoder_on_link": link}}


def flexibility(stiffness, damping, link=0.0):
    joint = {"stiffness": {"hinge": stiffness}, "damping": {"hinge": damping}}
    return {"joint_flexibility": joint | {"encoder_on_link": link}}


@pytest.mark.parametrize("link", [0.0, 1.0])
def test_a_flexible_joint_twists_under_the_load(tmp_path, link):
    stiffness = 40.0
    q = at_rest(pendulum(tmp_path), flexibility(stiffness, 0.5, link))
    motor_torque = KP * (0.8 - q)
    twist = motor_torque / stiffness
    true_link = q if link else q - twist
    assert motor_torque == pytest.approx(WEIGHT * np.sin(true_link), abs=1e-5)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_in_backlash_the_link_hangs_on_the_side_of_its_weight(tmp_path, side):
    play = 0.06
    effects = backlash(play, 0.0)
    q = at_rest(pendulum(tmp_path), effects, 0.8 * side)
    assert KP * (0.8 * side - q) == pytest.approx(
        WEIGHT * np.sin(q - side * play / 2), abs=2e-3 * WEIGHT
    )


@pytest.mark.parametrize("order", [1, -1])
def test_a_spring_behind_teeth_gives_as_both_do(tmp_path, order):
    stiffness, play, contact_time = 40.0, 0.02, 1e-3
    parts = [flexibility(stiffness, 0.5), backlash(play, 0.0, contact_time)][::order]
    q = at_rest(pendulum(tmp_path), parts[0] | parts[1])
    load = KP * (0.8 - q)
    twist = q - np.arcsin(load / WEIGHT)
    # the gear between is a tenth of the motor, and teeth are a spring on what they move
    teeth = 0.1 * ARMATURE / contact_time**2
    assert twist == pytest.approx(load / stiffness + play / 2 + load / teeth, rel=0.02)


@pytest.mark.parametrize("link", [0.0, 1.0])
@pytest.mark.parametrize("compensated", [False, True])
@pytest.mark.parametrize("effects", [partial(flexibility, 40.0, 0.5), partial(backlash, 0.06)])
def test_a_joint_in_two_parts_starts_under_its_load(tmp_path, effects, link, compensated):
    """An arm at rest stays at rest: spring or teeth bear the load from the first moment."""
    robot = pendulum(tmp_path)
    rest = at_rest(robot, effects(link), gravity_compensation=compensated)
    made = recording(robot, hold(0.8), duration_s=0.3, kd=1.5)
    made = dataclasses.replace(made, gravity_compensation=compensated, q=np.full_like(made.q, rest))
    assert np.ptp(predict(made, effects(link))) < 1.5e-3


# ------------------------------------------------------------------------------- dry friction

FRICTIONS = {
    "coulomb_friction": {"torque": {"hinge": 0.1}},
    "stribeck_friction": {
        "coulomb": {"hinge": 0.04}, "extra_at_rest": {"hinge": 0.06}, "velocity": {"hinge": 0.1},
    },
}  # fmt: skip


@pytest.mark.parametrize("name", FRICTIONS)
@pytest.mark.parametrize("share", [0.9, -0.9])
def test_below_its_level_friction_holds_a_joint_at_rest(tmp_path, name, share):
    made = recording(spinner(tmp_path), step(share * 0.1 / KP), duration_s=1.2)
    q = predict(made, {name: FRICTIONS[name]})
    assert np.abs(q).max() < 1e-4
    assert abs(q[-1] - q[60]) < 2e-6


@pytest.mark.parametrize("name", FRICTIONS)
def test_above_its_level_a_joint_moves(tmp_path, name):
    made = recording(spinner(tmp_path), step(1.5 * 0.1 / KP), duration_s=1.2)
    assert predict(made, {name: FRICTIONS[name]})[-1] > 0.1 * 0.1 / KP


SPEED = 0.6


def lag(robot, effects, speed=SPEED):
    """q_des − q in steady motion; the springs carry what resists."""
    made = recording(robot, ramp(speed), kd=1.0, duration_s=1.5, row_rate_hz=1000.0)
    return speed * 1.5 - predict(made, effects)[-1]


@pytest.mark.parametrize(
    ("name", "values", "resists"),
    [
        ("viscous_friction", {"damping": 0.3}, 0.3 * SPEED),
        ("viscous_friction", {"damping": -0.01}, -0.01 * SPEED),
        ("viscous_friction", {"damping": -5.0}, -DAMPING * SPEED),
        ("quadratic_friction", {"coefficient": 0.3}, 0.3 * SPEED**2),
        ("coulomb_friction", {"torque": 0.1}, 0.1),
        (
            "stribeck_friction",
            {"coulomb": 0.05, "extra_at_rest": 0.2, "velocity": 0.5},
            0.05 + 0.2 * np.exp(-((SPEED / 0.5) ** 2)),
        ),
        # the motor's torque τ carries the MJCF's damping and the friction itself: τ = d q̇ + μ τ
        ("load_dependent_friction", {"motor": 0.5, "load": 0.0}, DAMPING * SPEED),
        ("controller_gains", {"kp_factor": 0.5, "kd_factor": 1.0}, (1.0 + DAMPING) * SPEED),
        ("controller_gains", {"kp_factor": 1.0, "kd_factor": 2.0}, 1.0 * SPEED),
        ("torque_offset", {"torque": -0.1}, 0.1),
    ],
)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_steady_motion_lags_by_what_resists(tmp_path, name, values, resists, direction):
    if name == "torque_offset":
        resists *= direction
    effects = {name: {k: {"hinge": v} for k, v in values.items()}}
    found = lag(spinner(tmp_path), effects, direction * SPEED)
    plain = (1.0 + DAMPING) * SPEED
    assert direction * KP * found == pytest.approx(plain + resists, rel=3e-3)


def test_load_dependent_friction_holds_in_proportion_to_the_load(tmp_path):
    """Under gravity alone the gears bear (μm + μl) times the weight: the arm stays where it is."""
    made = recording(pendulum(tmp_path), hold(0.8), duration_s=1.5)
    weight = WEIGHT * np.sin(0.8)
    commanded = dataclasses.replace(made, q_des=np.full_like(made.q_des, 0.8 + 0.95 * weight / KP))
    enough = {"motor": {"hinge": 0.05}, "load": {"hinge": 0.05}}
    little = {"motor": {"hinge": 0.02}, "load": {"hinge": 0.02}}
    assert np.abs(predict(commanded, {"load_dependent_friction": enough}) - 0.8).max() < 1e-4
    assert np.abs(predict(commanded, {"load_dependent_friction": little}) - 0.8).max() > 5e-4


# ------------------------------------------------------------------- from command to torque


def test_a_delay_of_whole_ticks_shifts_the_command(tmp_path):
    robot, late = pendulum(tmp_path), 0.023
    made = recording(robot, swing(), row_rate_hz=1000.0, duration_s=0.8)
    rows = np.maximum(np.arange(len(made.time)) - 23, 0)
    shifted = dataclasses.replace(made, q_des=made.q_des[rows])
    q = predict(made, {"command_delay": {"delay": late}})
    np.testing.assert_allclose(q, predict(shifted), atol=1e-12)


def test_a_delay_between_ticks_lies_between_them(tmp_path):
    made = recording(pendulum(tmp_path), swing(), duration_s=0.8)
    less, between, more = (
        predict(made, {"command_delay": {"delay": d}}) for d in (0.023, 0.0234, 0.024)
    )
    np.testing.assert_allclose(between, 0.6 * less + 0.4 * more, atol=1e-6)


def test_samples_of_another_clock_are_those_of_a_later_time(tmp_path):
    """Between two ticks of the loop, which keeps its own time and commands."""
    robot, rate = pendulum(tmp_path), 100
    held = lambda t: swing()(np.floor(t * rate + 1e-6) / rate)  # noqa: E731
    often = recording(robot, held, control_rate_hz=200.0, row_rate_hz=1000.0)
    seldom = recording(robot, held, control_rate_hz=200.0, row_rate_hz=float(rate))
    for late_ms in (2, 4):
        offset = {"clock_offset": {"offset": -1e-3 * late_ms}}
        # the last one would be after the end
        found, wanted = predict(seldom, offset)[:-1], predict(often)[late_ms::10]
        np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_with_a_clock_offset_commands_are_in_force_before_their_stamps(tmp_path):
    made = recording(pendulum(tmp_path), swing(), row_rate_hz=1000.0, duration_s=0.8)
    rows = np.minimum(np.arange(len(made.time)) + 23, len(made.time) - 1)
    early = dataclasses.replace(made, q_des=made.q_des[rows])
    q = predict(made, {"clock_offset": {"offset": -0.023}})
    np.testing.assert_allclose(q, predict(early), atol=1e-12)


def test_a_late_command_is_filtered_too(tmp_path):
    made = recording(pendulum(tmp_path), swing(), row_rate_hz=1000.0, duration_s=0.5)
    rows = np.maximum(np.arange(len(made.time)) - 15, 0)
    shifted = dataclasses.replace(made, q_des=made.q_des[rows])
    filtered = {"command_filter": {"cutoff": 5.0}}
    q = predict(made, {**filtered, "command_delay": {"delay": 0.015}})
    np.testing.assert_allclose(q, predict(shifted, filtered), atol=1e-12)


def test_a_filtered_ramp_is_late_by_the_time_constant(tmp_path):
    cutoff, speed = 3.0, 0.6
    late = lag(spinner(tmp_path), {"command_filter": {"cutoff": cutoff}}) - lag(
        spinner(tmp_path), {}
    )
    assert late / speed == pytest.approx(1 / (2 * np.pi * cutoff), abs=0.0011)


def test_a_filtered_step_is_an_exponential(tmp_path):
    """A filter in the robot is a command that was filtered before."""
    robot, cutoff, at = spinner(tmp_path), 4.0, 100
    made = recording(robot, step(0.5), row_rate_hz=1000.0, duration_s=0.8)
    ticks = np.arange(len(made.time))[:, None] - at
    # the tick of the step sees the filter after its first period
    filtered = np.where(ticks < 0, 0.0, 0.5 * -np.expm1(-2 * np.pi * cutoff * 0.001 * (ticks + 1)))
    q = predict(made, {"command_filter": {"cutoff": cutoff}})
    np.testing.assert_allclose(q, predict(dataclasses.replace(made, q_des=filtered)), atol=1e-12)


def test_a_torque_constant_is_a_factor_on_both_gains(tmp_path):
    made, k = recording(pendulum(tmp_path), swing()), 0.7
    q = predict(made, {"torque_constant": {"factor": {"hinge": k}}})
    gains = {"kp_factor": {"hinge": k}, "kd_factor": {"hinge": k}}
    np.testing.assert_allclose(q, predict(made, {"controller_gains": gains}), atol=1e-12)
    scaled = dataclasses.replace(made, kp=k * made.kp, kd=k * made.kd)
    np.testing.assert_allclose(q, predict(scaled), atol=1e-12)


def test_a_saturated_motor_accelerates_by_its_limit(tmp_path):
    limit = 0.2
    made = recording(spinner(tmp_path, f'armature="{INERTIA - LINK}"'), step(1.0, 0.0), kp=50, kd=0)
    made = dataclasses.replace(made, q=np.zeros_like(made.q))
    q = predict(made, {"torque_saturation": {"limit": {"hinge": limit}}})
    pushed = made.time < 0.3  # far from the command: at the limit all the while
    np.testing.assert_allclose(q[pushed], 0.5 * limit / INERTIA * made.time[pushed] ** 2, atol=1e-9)


def test_saturation_cuts_what_compensates_gravity_too(tmp_path):
    """A motor too weak to hold the arm lets it fall, whatever it is commanded."""
    made = recording(pendulum(tmp_path), hold(1.2), duration_s=2.0, gravity_compensation=True)
    weak, strong = 0.5 * WEIGHT, 1.1 * WEIGHT
    assert predict(made, {"torque_saturation": {"limit": {"hinge": strong}}})[-1] == pytest.approx(
        1.2, abs=1e-9
    )
    q = predict(made, {"torque_saturation": {"limit": {"hinge": weak}}})
    assert q.min() < np.arcsin(0.5) + 0.01


@pytest.mark.parametrize("ramp", [0.0, 1.0])
def test_a_limited_torque_rate_jerks_a_joint_evenly(tmp_path, ramp):
    rate = 4.0
    made = recording(spinner(tmp_path, f'armature="{INERTIA - LINK}"'), step(3.0), kp=50, kd=0)
    q = predict(made, {"torque_rate_limit": {"rate": {"hinge": rate}, "ramp": ramp}})
    since = np.clip(made.time - 0.1, 0, None)
    early = since < 0.3
    if ramp:  # the mean over each period, which starts a joint a little faster
        expected = rate / INERTIA * (since**3 / 6 + 0.001**2 * since / 12)[early]
        np.testing.assert_allclose(q[early], expected, rtol=1e-3)
    else:  # the torque of a period is that of its end: half a period early on average
        expected = rate / INERTIA * ((since + 0.0005) ** 3)[early] / 6
        np.testing.assert_allclose(q[early], expected, atol=5e-5)


def test_armature_lengthens_the_period(tmp_path):
    kp, added = 8.0, 0.02
    made = recording(spinner(tmp_path, 'armature="0.005"'), hold(0.0), kp=kp, kd=0, duration_s=2.0)
    made = dataclasses.replace(made, q=np.full_like(made.q, 0.3))

    def period(q):
        at = np.flatnonzero((q[:-1] < 0) & (q[1:] >= 0))
        crossings = made.time[at] + 0.01 * q[at] / (q[at] - q[at + 1])
        return np.diff(crossings).mean()

    plain, heavier = (
        period(predict(made)),
        period(predict(made, {"armature": {"inertia": {"hinge": added}}})),
    )
    assert plain == pytest.approx(2 * np.pi * np.sqrt(INERTIA / kp), rel=5e-3)
    assert heavier / plain == pytest.approx(np.sqrt(1 + added / INERTIA), rel=5e-3)


@pytest.mark.parametrize("compensated", [False, True])
def test_a_slow_loop_equals_a_recording_at_its_rate(tmp_path, compensated):
    made = recording(pendulum(tmp_path), swing(), row_rate_hz=50.0)
    made = dataclasses.replace(made, gravity_compensation=compensated)
    q = predict(made, {"low_rate_loop": {"rate": 250.0, "phase": 0.0}})
    slow = dataclasses.replace(made, control_rate_hz=250.0)
    np.testing.assert_allclose(q, predict(slow), atol=3e-5)
    assert np.abs(q - predict(made)).max() > 1e-3


def test_a_slow_loop_at_a_rate_that_does_not_divide_the_loops(tmp_path):
    """300 Hz in a loop of 1 kHz: between 333 and 250 Hz in what it does."""
    made = recording(pendulum(tmp_path), swing(), row_rate_hz=50.0)
    plain = predict(made)

    def size(rate):
        return np.abs(predict(made, {"low_rate_loop": {"rate": rate, "phase": 0.0}}) - plain).mean()

    assert size(1000 / 3) < size(300.0) < size(250.0)


def driven(made, motion, state, torque_at):
    """Samples of a machine integrated by SciPy, its command held between ticks of 1 kHz."""
    found = []
    for tick in range(int(made.time[-1] * 1000) + 1):
        if tick % 10 == 0:
            found.append(state[0])
        command = made.q_des[tick // 10, 0]
        torque = torque_at(command, state)
        state = solve_ivp(
            lambda _, x, torque=torque: motion(x, torque), (0, 1e-3), state, rtol=1e-9, atol=1e-12
        ).y[:, -1]
    return np.array(found)


def test_a_lagging_motor_solves_its_equation(tmp_path):
    cutoff = 15.0
    made = recording(spinner(tmp_path), step(0.5), duration_s=0.4)

    def motion(x, demand):
        return x[1], (x[2] - DAMPING * x[1]) / INERTIA, 2 * np.pi * cutoff * (demand - x[2])

    expected = driven(made, motion, np.zeros(3), lambda c, x: 20 * (c - x[0]) - 0.8 * x[1])
    q = predict(made, {"actuator_bandwidth": {"cutoff": {"hinge": cutoff}}})
    np.testing.assert_allclose(q, expected, atol=2e-4)
    assert np.abs(predict(made) - expected).max() > 0.02


def test_ripple_that_is_held_between_ticks_solves_the_smooth_equation(tmp_path):
    level, n = 0.3, 150.0
    made = recording(spinner(tmp_path), step(0.8), kp=60.0, duration_s=0.4)

    def motion(x, torque):
        return x[1], (torque + level * np.sin(n * x[0]) - DAMPING * x[1]) / INERTIA

    expected = driven(made, motion, np.zeros(2), lambda c, x: 60 * (c - x[0]) - 0.8 * x[1])
    values = {"amplitude": {"hinge": level}, "phase": {"hinge": 0.0}, "periods": {"hinge": n}}
    error = predict(made, {"cogging": values}) - expected
    assert np.abs(error).max() < 3e-4
    assert np.abs(predict(made) - expected).max() > 2e-3


@pytest.mark.parametrize("link", [0.0, 1.0])
def test_a_flexible_joint_solves_its_equation(tmp_path, link):
    stiffness, damping = 15.0, 0.05
    made = recording(spinner(tmp_path, 'armature="0.005"'), step(0.3), kd=0.3, duration_s=0.4)

    def motion(x, torque):
        between = stiffness * (x[2] - x[0]) + damping * (x[3] - x[1])
        return x[1], between / LINK, x[3], (torque - between) / 0.005

    seen = 0 if link else 2
    order = [0, 1, 2, 3] if link else [2, 3, 0, 1]

    def torque(command, x):
        at = np.argsort(order)
        q, dq = x[at][seen], x[at][seen + 1]
        return 20 * (command - q) - 0.3 * dq

    def reordered(x, torque):
        # the state that is seen comes first
        at = np.argsort(order)
        return np.array(motion(x[at], torque))[order]

    expected = driven(made, reordered, np.zeros(4), torque)
    q = predict(made, flexibility(stiffness, damping, link), substeps=4)
    np.testing.assert_allclose(q, expected, atol=1.5e-3)
    assert np.abs(predict(made) - expected).max() > 0.01


def test_a_stiffer_joint_is_nearer_to_the_rigid_plant(tmp_path):
    made = recording(pendulum(tmp_path), swing(), duration_s=0.8)
    rigid = predict(made, substeps=2)
    error = []
    for stiffness in (50.0, 200.0, 800.0):
        q = predict(made, flexibility(stiffness, 1.0))
        error.append(np.sqrt(np.mean((q - rigid) ** 2)))
    assert error[0] > 2 * error[1] > 4 * error[2]


def test_teeth_give_under_the_load_as_a_spring_does(tmp_path):
    """A spring of ω² times the reduced inertia: four times as soft with twice the time."""
    robot = pendulum(tmp_path)

    def twist(contact_time):
        q = at_rest(robot, backlash(1e-3, 0.0, contact_time))
        load = KP * (0.8 - q)  # the link hangs where gravity gives this torque
        return (q - np.arcsin(load / WEIGHT) - 5e-4) / load

    assert twist(8e-3) == pytest.approx(4 * twist(4e-3), rel=0.05)
    assert twist(8e-3) > 1e-4


@pytest.mark.parametrize("damping", [0.1, 0.5])
def test_how_teeth_bounce_depends_on_their_damping(tmp_path, damping):
    made = recording(spinner(tmp_path), step(0.3), duration_s=1.0)
    hard = predict(made, backlash(0.05, 1.0, damping=1.0))
    assert np.abs(predict(made, backlash(0.05, 1.0, damping=damping)) - hard).max() > 1e-4


def test_backlash_frees_the_link_at_reversals(tmp_path):
    """With a heavier hand of play the link's encoder sees more of it."""
    made = recording(spinner(tmp_path), swing(0.4, 1.0, 0.0), duration_s=1.0)

    def change(play):
        return np.sqrt(np.mean((predict(made, backlash(play, 1.0)) - predict(made)) ** 2))

    assert 1e-4 < change(0.01) < change(0.05) < 0.05


def test_the_equilibria_above_are_the_ones_of_the_pendulum():
    """The plain pendulum of these tests does sag: the loads are not lost in rounding."""
    sag = 0.8 - brentq(lambda q: KP * (0.8 - q) - WEIGHT * np.sin(q), 0, 0.8)
    assert sag > 0.03
