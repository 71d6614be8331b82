"""What a model leaves along the measured motion, and what the search makes of it."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.detective.along_motion import AlongMotion, fit_along, of_joints, together
from t2l.detective.candidates import encoded
from t2l.detective.data_split import split
from t2l.detective.explanation import explained
from t2l.detective.fit import Samples, fit_sets
from t2l.detective.fitted_set import FittedSet, Start
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.responses import added_torques, stiffness
from t2l.detective.rule import Judge
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.first_guesses import first_guesses
from t2l.identify.model import Model
from t2l.identify.scales import sized
from tests.diagnose.made import (
    measured,
    pendulum,
    recording,
    step,
    swing,
    swings,
    two_pendulums,
)

BARE = Layout(()), np.zeros(0)
NOISE_RAD = 1e-4
# each moves the pendulum by far more than the noise, and changes its loop
LARGE = {
    "coulomb_friction": {"torque": 0.3},
    "viscous_friction": {"damping": 0.3},
    "payload": {"mass": 0.3, "com_x": 0.0, "com_y": 0.0, "com_z": 0.0},
    "torque_constant": {"factor": 0.6},
    "velocity_filter": {"cutoff": 5.0},
    "dahl_friction": {"coulomb": 0.2, "presliding": 0.005},
}
WIDE = {
    "torque_1": 0.05, "radius_1": 0.1, "torque_2": 0.05, "radius_2": 0.3,
    "torque_3": 0.05, "radius_3": 0.9,
}  # fmt: skip
ELEMENTS = {
    "torque_1": 0.05, "radius_1": 0.01, "torque_2": 0.05, "radius_2": 0.05,
    "torque_3": 0.05, "radius_3": 0.2,
}  # fmt: skip


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def along_of(data):
    samples = Samples.of(data.fitted, data.fitted_mask, data.folds, BARE, NOISE_RAD)
    whole = replace(samples, linear=samples.exact)
    (so_far,) = fit_sets([Start(*BARE)], whole, iterations=0)
    sections = linearised(data.fitted, *BARE, measured_motion(data.fitted, *BARE))
    return AlongMotion(data.fitted, sections, data.fitted_mask, so_far.known, NOISE_RAD), so_far


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_along_its_own_motion_a_model_leaves_what_its_simulation_does(robot):
    hidden = {"viscous_friction": {"damping": {"hinge": 0.3}}}
    data = split(robot, swings(robot, hidden, NOISE_RAD), swings(robot)[:1], threads=1)
    _, so_far = along_of(data)
    own = [motion.foretold() for motion in measured_motion(data.fitted, *BARE)]
    sections = linearised(data.fitted, *BARE, own)
    along = AlongMotion(data.fitted, sections, data.fitted_mask, so_far.known, NOISE_RAD)
    assert along.rmse == pytest.approx(rms(so_far.residual), rel=1e-4)


def test_fits_that_race_find_the_same_best_with_less_work(robot, monkeypatch):
    hidden = {"coulomb_friction": {"torque": {"hinge": 0.2}}}
    data = split(robot, swings(robot, hidden, NOISE_RAD), swings(robot)[:1], threads=1)
    along, _ = along_of(data)
    starts = []
    for name, values in LARGE.items():
        layout = Layout([Term(builtin()[name], (0,))])
        u = layout.encode({name: {key: np.array([value]) for key, value in values.items()}})
        starts.append(Start(layout, u))
    points, residuals = [], along.residuals

    def counted(asked):
        points.append(sum(len(some) for _, some in asked))
        return residuals(asked)

    monkeypatch.setattr(along, "residuals", counted)
    best, work = [], []
    for racing in (False, True):
        fits = fit_along(starts, along, data.folds, racing=racing)
        best.append(min(fits, key=lambda fit: fit.rmse))
        work.append(sum(points))
        points.clear()
    assert dict(best[0].names) == dict(best[1].names)
    assert best[1].rmse == pytest.approx(best[0].rmse, rel=1e-6)
    assert work[1] < work[0]


def test_a_fit_begins_at_unmoved_numbers_where_these_leave_less(robot):
    hidden = {"coulomb_friction": {"torque": {"hinge": 0.2}}}
    data = split(robot, swings(robot, hidden, NOISE_RAD), swings(robot)[:1], threads=1)
    along, _ = along_of(data)
    layout = Layout([Term(builtin()[name], (0,)) for name in ("coulomb_friction", "payload")])
    at = {key: np.array([0.0]) for key in ("com_x", "com_y", "com_z")}
    near, far = (
        layout.encode(
            {
                "coulomb_friction": {"torque": np.array([0.2])},
                "payload": {"mass": np.array([mass]), **at},
            }
        )
        for mass in (0.0, 3.0)
    )
    for begins, else_begins in ((far, near), (near, far)):
        (fit,) = fit_along([Start(layout, begins, unmoved=else_begins)], along, data.folds, 0)
        assert fit.u == pytest.approx(near)


@pytest.mark.parametrize("name", LARGE)
def test_the_truth_leaves_little_however_far_the_model_so_far_is(robot, name):
    effect = builtin()[name]
    hidden = {
        name: {
            p.name: {"hinge": LARGE[name][p.name]} if p.per_joint else LARGE[name][p.name]
            for p in effect.parameters
        }
    }
    data = split(robot, swings(robot, hidden, duration_s=2.0), swings(robot)[:1], threads=1)
    along, so_far = along_of(data)
    layout = Layout([Term(effect, (0,))])
    u = layout.encode({name: {key: np.array([v]) for key, v in LARGE[name].items()}})
    (truth,) = fit_along([Start(layout, u)], along, data.folds, 0)
    assert rms(so_far.residual) > 30 * NOISE_RAD
    assert rms(truth.residual) < 0.1 * rms(so_far.residual)


def test_points_that_move_one_joint_each_have_the_torques_of_fewer_points(tmp_path):
    """Of every effect with numbers of single joints, to the last digit."""
    robot = two_pendulums(tmp_path)
    commands = lambda t: np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)  # noqa: E731
    logs = [measured(recording(robot, commands, kp=20.0), noise_rad=NOISE_RAD)]
    data = split(robot, logs, logs, threads=1)
    along, _ = along_of(data)
    model, counts = sized(Model(robot), data.fitted), {}
    for effect in model.known_effects(data.fitted.joints).values():
        if effect.needs or not effect.may_act(data.fitted.recordings):
            continue
        layout = Layout([Term(effect, (0, 1))])
        encode = encoded(first_guesses(effect, model.sizes, 2)[0])
        u = np.clip([encode(slot) for slot in layout.slots], layout.lower, layout.upper)
        points = u + np.vstack([np.zeros(len(u)), 0.01 * np.diag(np.maximum(np.abs(u), 0.1))])
        points = np.clip(points, layout.lower, layout.upper)
        rows, of = together(layout, points, 2)
        counts[effect.name] = len(points) - len(rows)
        (section,) = along.sections
        (apart,) = added_torques(data.fitted, section, along.base, [(layout, points)])
        (alike,) = added_torques(data.fitted, section, along.base, [(layout, rows)])
        np.testing.assert_array_equal(apart, of_joints(alike, of, 1), err_msg=effect.name)
    assert counts["coulomb_friction"] == 1
    assert counts["controller_gains"] == 2
    assert counts["encoder_eccentricity"] == counts["supply_sag"] == 0


def test_the_model_so_far_leaves_what_its_simulation_leaves(robot):
    hidden = {"coulomb_friction": {"torque": {"hinge": 0.01}}}
    data = split(robot, swings(robot, hidden, duration_s=2.0), swings(robot)[:1], threads=1)
    along, so_far = along_of(data)
    assert rms(along.residual - so_far.residual) < 0.1 * rms(so_far.residual)


def test_between_two_ticks_of_a_slow_loop_positions_are_those_of_a_simulation(robot):
    made = recording(robot, step(0.3), kp=20.0, kd=0.8, control_rate_hz=50.0, row_rate_hz=250.0)
    logs = [measured(made, noise_rad=1e-5, seed=seed) for seed in (0, 1)]
    data = split(robot, logs, logs[:1], threads=1)
    along, so_far = along_of(data)
    assert rms(along.residual - so_far.residual) < 1e-5


@pytest.mark.parametrize("memory", ["torque_delay", "actuator_bandwidth", "velocity_filter"])
def test_behind_a_motor_that_remembers_torques_are_those_of_the_whole_loop(robot, memory):
    values = {"torque_delay": {"delay": 0.004}}.get(memory, {"cutoff": 10.0})
    numbers = {memory: {name: np.array([value]) for name, value in values.items()}}
    data = split(robot, swings(robot), swings(robot)[:1], threads=1)
    base = Layout([Term(builtin()[memory], (0,))])
    model = base, base.encode(numbers)
    whole = Layout([*base.terms, Term(builtin()["viscous_friction"], (0,))])
    u = whole.encode({**numbers, "viscous_friction": {"damping": np.array([0.1])}})
    for motion in measured_motion(data.fitted, *model):
        (section,) = linearised(data.fitted, *model, [motion])
        (quick,) = added_torques(data.fitted, section, model, [(whole, u[None])])
        assert section.motor_torque(data.fitted, model) is not None
        # what is not known is computed tick by tick
        section = replace(section, _motors={next(iter(section._motors)): None})
        (slow,) = added_torques(data.fitted, section, model, [(whole, u[None])])
        assert np.abs(slow).max() > 0.01
        assert np.abs(quick - slow).max() < 1e-5 * np.abs(slow).max()


def fitted_set(numbers, error, seed=0, names=("armature",)):
    """Numbers that the samples tell, one name each, and an error of Gaussian samples."""
    rng = np.random.default_rng(seed)
    layout = Layout([Term(builtin()[name], (0,)) for name in names])
    n = len(layout.slots)
    jacobian = rng.normal(size=(2000, n))
    jacobian[:, numbers:] = 0.0
    residual = error * rng.normal(size=2000)
    return FittedSet(
        layout, np.zeros(n), residual, residual, np.ones(2000, bool), jacobian, np.ones(n, bool)
    )


JUDGE = Judge(np.arange(2000) // 20, 1e-3)


@pytest.mark.parametrize(
    ("numbers", "error", "taken"),
    [
        # more numbers earn 5 %, as many what is sure, fewer may lose what is not missed
        (3, 0.97, False),
        (3, 0.80, True),
        (2, 0.80, True),
        (2, 1.05, False),
        (1, 1.02, True),
        (1, 1.60, False),
    ],
)
def test_what_takes_the_place_of_a_set_depends_on_its_numbers(numbers, error, taken):
    before = fitted_set(2, 1.0, names=("controller_gains",))
    after = fitted_set(numbers, error, names=("payload",))
    assert JUDGE.takes(before, after) == taken


def test_names_that_explain_alike_are_told(robot):
    """A tilted pendulum hangs as one whose encoder is off by the angle."""
    hidden = {"base_tilt": {"roll": 0.0, "pitch": 0.1}}
    explanation = explained(Model(robot), split(robot, swings(robot, hidden), threads=1))
    names = {"base_tilt", "encoder_offset"}
    (found,) = names & set(explanation.model.effects)
    (entry,) = [entry for entry in explanation.confounded if entry.effect == found]
    assert {*(names - {found})} in [set(rival.effects) for rival in entry.rivals]
    assert "These recordings cannot tell" in explanation.sentence


@pytest.mark.parametrize(
    ("name", "values", "times", "more"),
    [
        ("torque_constant", {"factor": 0.5}, 0.5, 0.0),
        ("parallel_spring", {"stiffness": 0.7, "rest": 0.2}, 1.0, 0.7),
        ("viscous_friction", {"damping": 0.5}, 1.0, 0.0),
    ],
)
def test_the_stiffness_of_a_loop_is_that_of_motor_and_springs(robot, name, values, times, more):
    data = split(robot, swings(robot, duration_s=2.0), swings(robot)[:1], threads=1)
    along, _ = along_of(data)
    layout = Layout([Term(builtin()[name], (0,))])
    u = np.array([values[slot.parameter.name] for slot in layout.slots], float)
    u[layout.log] = np.log(u[layout.log])
    for section, own in zip(along.sections, along.stiffness, strict=True):
        (found,) = stiffness(data.fitted, section, [(layout, u[None])])
        np.testing.assert_allclose(found[0], times * own[0] + more, rtol=1e-4)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("dahl_friction", {"coulomb": 0.15, "presliding": 0.02}),
        ("maxwell_slip_friction", ELEMENTS),
        ("integral_action", {"gain": 12.0, "limit": 2.0}),
    ],
)
def test_what_is_held_where_logs_begin_is_free(robot, name, values):
    """Logs that begin in motion: in the middle of what bristles or an integral do."""
    hidden = {name: {key: {"hinge": value} for key, value in values.items()}}
    logs = []
    for kp, kd, from_s in ((10, 0.4, 0.8), (20, 0.8, 0.85)):
        whole = recording(robot, swing(0.6, 1.1), f"kp{kp}", kp, kd, 3.0, row_rate_hz=200.0)
        whole = measured(whole, hidden, NOISE_RAD)
        rows = whole.time >= from_s
        time = whole.time[rows] - whole.time[rows][0]
        logs.append(replace(whole, time=time, q_des=whole.q_des[rows], q=whole.q[rows]))
    data = split(robot, logs, logs[:1], threads=1)
    assert data.fitted.in_motion
    layout, u = Model(robot, hidden).vector(data.fitted.joints)
    along, came = along_of(data)
    (free,) = fit_along([Start(layout, u)], along, data.folds, 0)
    assert came.rmse > 100 * NOISE_RAD
    assert free.rmse < 1.5 * NOISE_RAD


@pytest.mark.parametrize("compensation", [True, "continuous"])
@pytest.mark.parametrize("name", ["dahl_friction", "maxwell_slip_friction"])
def test_what_remembers_begins_in_balance_where_the_weight_is_carried(robot, name, compensation):
    """From rest nothing is stretched, and wide elements never forget if it were."""
    values = {"coulomb": 0.15, "presliding": 0.4} if name == "dahl_friction" else WIDE
    hidden = {name: {key: {"hinge": value} for key, value in values.items()}}
    logs = [
        measured(
            recording(
                robot, swing(0.4, hz, 0.8), f"kp{kp}", kp, kd, 2.0, row_rate_hz=200.0,
                gravity_compensation=compensation,
            ),
            hidden,
            NOISE_RAD,
        )
        for kp, kd, hz in ((10, 0.4, 0.8), (20, 0.8, 1.1))
    ]  # fmt: skip
    data = split(robot, logs, logs[:1], threads=1)
    assert not data.fitted.in_motion
    layout, u = Model(robot, hidden).vector(data.fitted.joints)
    along, came = along_of(data)
    (true,) = fit_along([Start(layout, u)], along, data.folds, 0)
    assert came.rmse > 50 * NOISE_RAD
    # bent by the weight they would leave more than 30 times the noise
    assert true.rmse < 5 * NOISE_RAD
