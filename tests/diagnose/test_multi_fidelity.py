from dataclasses import replace

import numpy as np
import pytest

from t2l.diagnose.evidence import gather
from t2l.diagnose.multi_fidelity import SCREENED_S, with_beginnings, with_coarser_ticks
from t2l.diagnose.racing import fit_all, fit_fully
from t2l.diagnose.ranking import diagnose
from t2l.effects.effect import Effect, Parameter
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import scales
from tests.diagnose.made import measured, pendulum, recording, swing, swings, two_pendulums

HIDDEN = {"viscous_friction": {"damping": {"hinge": 0.05}}}
MODERATE = {
    "encoder_eccentricity": {"amplitude": [0.03, 0.03], "phase": [1.0, 1.0]},
    "actuator_bandwidth": {"cutoff": 8.0},
    "backlash": {"play": 0.02, "contact_time": 0.01, "contact_damping": 0.7, "encoder_on_link": 1},
    "joint_flexibility": {"stiffness": 20.0, "damping": 0.05, "encoder_on_link": 1},
    "base_tilt": {"roll": 0.2, "pitch": 0.2},
    "command_delay": {"delay": 0.03},
    "low_rate_loop": {"rate": 50.0, "phase": 0.0},
    "load_dependent_friction": {"motor": 0.2, "load": 0.2},
    "lugre_friction": {
        "coulomb": 0.1,
        "extra_at_rest": 0.05,
        "velocity": 0.3,
        "presliding": 0.02,
        "damping": 0.1,
    },
    "stribeck_friction": {"coulomb": 0.1, "extra_at_rest": 0.05, "velocity": 0.1},
    "torque_rate_limit": {"rate": 10.0, "ramp": 0.0},
    "torque_saturation": {"limit": 1.0},
}
STICKY = {"coulomb": 0.038, "extra_at_rest": 0.077, "velocity": 0.145}

MANY = 9  # recordings, of which three are screened


def recordings(robot, count, effects=HIDDEN, noise_rad=1e-3):
    """Shaken at gains from compliant to stiff."""
    return [
        measured(
            recording(robot, swing(0.5, 0.9), f"r{i}", kp, 0.05 * np.sqrt(kp), 0.6),
            effects, noise_rad, seed=i,
        )
        for i, kp in enumerate(np.geomspace(5.0, 60.0, count))
    ]  # fmt: skip


def of(evidence):
    return {name: getattr(evidence, name).coarseness for name in ("screen", "shortlist")}


def coarsened(model, evidence):
    return with_coarser_ticks(evidence, *model.vector(evidence.train.joints))


def test_many_noisy_recordings_are_simulated_coarsely(tmp_path):
    robot = pendulum(tmp_path)
    made = recordings(robot, MANY + 6)
    evidence = gather(robot, made[:-3], made[-3:])
    found = coarsened(Model(robot), evidence)
    assert set(of(found).values()) == {5}
    # what a fit ends on and what judges is simulated tick by tick
    assert (found.train, found.validation) == (evidence.train, evidence.validation)
    assert found.train.coarseness == found.validation.coarseness == 1
    for coarse, exact in ((found.screen, evidence.screen), (found.shortlist, evidence.shortlist)):
        np.testing.assert_array_equal(coarse.samples.q, exact.samples.q)


@pytest.mark.parametrize(("noise_rad", "found"), [(1e-3, {5}), (1e-6, {1})])
def test_ticks_are_as_coarse_as_the_noise_hides(tmp_path, noise_rad, found):
    robot = pendulum(tmp_path)
    evidence = gather(robot, recordings(robot, 3, noise_rad=noise_rad))
    assert set(of(coarsened(Model(robot), evidence)).values()) == found


def test_a_fit_ends_on_every_tick_and_knows_no_bias(tmp_path):
    robot = pendulum(tmp_path)
    made = recordings(robot, MANY + 6)
    evidence = gather(robot, made[:-3], made[-3:])
    known = builtin()
    effects = [known[name] for name in ("viscous_friction", "coulomb_friction", "armature")]
    found = diagnose(Model(robot), evidence, effects)
    assert found.ranking[0].effect.name == "viscous_friction"
    assert found.ranking[0].validation_rmse_rad < 1.05 * found.noise_floor_rad
    layout = Layout([Term(effects[0], (0,))])
    fit = LeastSquares(layout, np.array([0.1]), np.array([0.1]), tolerance=1e-6)
    run([fit], evidence.train, evidence.train_mask, 20)
    assert found.ranking[0].u == pytest.approx(fit.u, rel=1e-3)


@pytest.mark.parametrize("name", sorted(n for n, e in builtin().items() if not e.needs))
def test_an_effect_changes_a_coarse_simulation_as_it_does_a_fine_one(tmp_path, name):
    """What chooses among effects must not depend on the ticks."""
    effect = builtin()[name]
    robot = two_pendulums(tmp_path)

    def both(t):
        return np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)

    compensated = name == "gravity_compensation_error"
    made = recording(robot, both, kp=15.0, kd=0.3, duration_s=1.0, gravity_compensation=compensated)
    fine = Predictor(robot, [made], threads=1)
    layout = Layout([Term(effect, (0, 1))])
    values = MODERATE.get(name) or effect.starts(scales(fine))[0]
    values = {key: np.atleast_1d(value) for key, value in values.items()}
    u = layout.encode({name: {s.parameter.name: values[s.parameter.name] for s in layout.slots}})
    plain = Request(Layout(()), np.zeros((1, 0)))

    def change(predictor):
        with_effect, without = predictor.predict([Request(layout, u[None]), plain])
        return with_effect[0] - without[0]

    expected, found = change(fine), change(fine.of(fine.recordings, 5))
    assert np.sqrt(np.mean(expected**2)) > 1e-3
    # a spring between motor and link is as quick as the ticks
    share = 0.25 if name == "joint_flexibility" else 0.1
    assert np.sqrt(np.mean((found - expected) ** 2)) < share * np.sqrt(np.mean(expected**2))


class _ByTicks(Effect):
    """Damping whose sign, or whose presence beside a push, depends on how coarse ticks are."""

    parameters = (Parameter("damping", "N·m·s/rad", -1.0, 1.0, "of the joint"),)
    summary = signature = source = title = "what no machine does"
    follows = "velocity"

    def __init__(self, name, fine_sign, fine_push):
        self.name, self.fine_sign, self.fine_push = name, fine_sign, fine_push

    def install(self, loop, rows, joints, values):
        fine = loop.period_s == loop.real_period_s
        sign, push = (self.fine_sign, self.fine_push) if fine else (1.0, 0.0)

        def add(tick, q, dq, torque):
            torque[rows, joints] += push - sign * values["damping"] * dq[rows, joints]

        loop.joint_torques.append(add)

    def starts(self, scales):
        return [{"damping": np.array([0.02])}]


def test_a_fit_that_only_coarse_ticks_allow_is_made_anew_on_all(tmp_path):
    robot = pendulum(tmp_path)
    made = recordings(robot, MANY + 6)
    evidence = gather(robot, made[:-3], made[-3:])
    found = diagnose(Model(robot), evidence, [_ByTicks("mirrored", -1.0, 0.0)])
    (first,) = found.ranking
    assert first.u == pytest.approx([-0.05], rel=0.02)
    assert first.train_rmse_rad < 0.2 * found.train_rmse_rad


def test_an_effect_that_only_coarse_ticks_favour_is_ranked_by_all_of_them(tmp_path):
    robot = pendulum(tmp_path)
    made = recordings(robot, MANY + 6)
    evidence = gather(robot, made[:-3], made[-3:])
    wild, plain = _ByTicks("wild", 1.0, 2.0), builtin()["coulomb_friction"]
    found = diagnose(Model(robot), evidence, [wild, plain])
    assert [c.effect.name for c in found.ranking] == ["coulomb_friction", "wild"]
    assert not found.ranking[1].justified
    # alone it is fitted to all, makes training worse, and is left out
    assert diagnose(Model(robot), evidence, [wild]).ranking == []


def two(robot, effects):
    return recordings(robot, 2, effects, noise_rad=1e-4)


@pytest.mark.parametrize(
    ("name", "values", "made"),
    [
        # what limits the torque from tick to tick
        ("torque_rate_limit", {"rate": {"hinge": 10.0}, "ramp": 0.0}, two),
        # four periods are as long as one of this loop
        ("low_rate_loop", {"rate": 250.0, "phase": 0.0}, swings),
        # what sticks and slips within a tick
        ("stribeck_friction", {p: {"hinge": v} for p, v in STICKY.items()}, two),
    ],
)
def test_what_coarse_ticks_led_astray_is_found_on_every_tick(tmp_path, name, values, made):
    robot = pendulum(tmp_path)
    exact = gather(robot, made(robot, {name: values}))
    coarse = exact.train.of(exact.train.recordings, 4)
    left = []
    for evidence in (exact, replace(exact, screen=coarse, shortlist=coarse)):
        fits = fit_all(
            evidence, Layout(()), np.zeros(0), [builtin()[name]], 1e-4, lambda what, fraction: None
        ).fits
        full = fit_fully(fits, [name], evidence)[name]
        left.append(np.sqrt(full.loss))
    assert left[1] < 1.05 * left[0]


def test_a_torque_limit_far_below_the_demand_is_found(tmp_path):
    robot = pendulum(tmp_path)
    hidden = {"torque_saturation": {"limit": {"hinge": 1.0}}}
    evidence = gather(robot, recordings(robot, 2, hidden, noise_rad=1e-4))
    effects, silent = [builtin()["torque_saturation"]], lambda what, fraction: None
    fits = fit_all(evidence, Layout(()), np.zeros(0), effects, 1e-4, silent).fits
    full = fit_fully(fits, list(fits), evidence)["torque_saturation"]
    assert np.sqrt(full.loss) < 1.1e-4
    assert full.layout.theta(full.u) == pytest.approx([1.0], rel=0.01)


SLOW = {"control_rate_hz": 250.0}


def sticky(made):
    """A recording of what has more friction than its model."""
    damping = {joint: 0.05 for joint in made.joints}
    return measured(made, {"viscous_friction": {"damping": damping}}, 1e-4)


def shortened(robot, evidence):
    return with_beginnings(evidence, *Model(robot).vector(evidence.train.joints))


@pytest.mark.parametrize("duration_s", [7.0, 12.0])
def test_a_long_recording_is_screened_by_its_beginning(tmp_path, duration_s):
    robot = pendulum(tmp_path)
    made = sticky(recording(robot, swing(), duration_s=duration_s, **SLOW))
    evidence = gather(robot, [made])
    found = shortened(robot, evidence)
    if duration_s < 1.5 * SCREENED_S:
        assert found is evidence
        return
    assert (found.train, found.validation) == (evidence.train, evidence.validation)
    assert found.shortlist is found.screen
    samples = found.screen.samples
    assert samples.time.max() == pytest.approx(SCREENED_S - 0.01)
    # the same samples of the same blocks, and the same motion
    early = evidence.train.samples.time < SCREENED_S
    np.testing.assert_array_equal(samples.q, evidence.train.samples.q[early])
    np.testing.assert_array_equal(found.screen_mask, evidence.train_mask[early])
    plain = [Request(Layout(()), np.zeros((1, 0)))]
    (part,), (whole,) = found.screen.predict(plain), evidence.train.predict(plain)
    np.testing.assert_array_equal(part[0], whole[0, early])


def test_what_shows_only_later_is_not_cut_off(tmp_path):
    """One joint after the other: the first seconds know nothing of the second one."""
    robot = two_pendulums(tmp_path)

    def one_by_one(t):
        early = t < 5.0
        left, right = swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)
        return np.stack([np.where(early, left, 0.0), np.where(early, 0.0, right)], axis=1)

    made = sticky(recording(robot, one_by_one, duration_s=10.0, **SLOW))
    evidence = gather(robot, [made])
    assert shortened(robot, evidence) is evidence


def test_what_is_shortlisted_stays_whole_where_it_is_more(tmp_path):
    robot = pendulum(tmp_path)
    made = [
        sticky(recording(robot, swing(), f"kp{kp:g}", kp, duration_s=8.0, **SLOW))
        for kp in (5.0, 10.0, 20.0, 40.0)
    ]
    evidence = gather(robot, made[:3], made[3:])
    found = shortened(robot, evidence)
    assert found.shortlist is evidence.shortlist
    assert found.screen.recordings[0].duration_s == pytest.approx(SCREENED_S - 0.01)
