"""A robot of other mass, under gains as much larger, moves alike; so the answer is the same."""

import dataclasses

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from t2l.detective.candidates import known_candidates, steps_of
from t2l.detective.data_split import split
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.search import search
from t2l.detective.starting_points import read_off
from t2l.effects.effect import SIZES
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.first_guesses import first_guesses
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import sized
from tests.diagnose.made import ARMATURE, DAMPING, LENGTH, MASS, measured, recording, swing
from tests.effects.made import POWERS
from tests.effects.test_ranges import power

HIDDEN = (
    {"coulomb_friction": {"torque": {"hinge": 0.05}}, "command_delay": {"delay": 0.02}},
    {"viscous_friction": {"damping": {"hinge": 0.1}}, "torque_offset": {"torque": {"hinge": 0.1}}},
)
FRICTION = 0.01
# each is a real run: none to shrink what failed
PHASES = (Phase.explicit, Phase.generate)
factors = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)


def pendulum(folder, factor):
    """Of tests.diagnose.made, with friction, all times the factor."""
    has = {"armature": ARMATURE, "damping": DAMPING, "frictionloss": FRICTION}
    joint = " ".join(f'{name}="{own * factor!r}"' for name, own in has.items())
    inertia = " ".join([repr(1e-4 * factor)] * 3)
    path = folder / f"pendulum_{factor!r}.xml"
    path.write_text(
        f'<mujoco><compiler angle="radian"/><worldbody><body pos="0 0 1">'
        f'<joint name="hinge" axis="0 1 0" {joint}/>'
        f'<inertial pos="0 0 {-LENGTH}" mass="{MASS * factor!r}" diaginertia="{inertia}"/>'
        f'<site name="attachment_site" pos="0 0 {-LENGTH}"/></body></worldbody></mujoco>'
    )
    return str(path)


def times(recordings, robot, factor):
    """The same positions of a robot as much heavier."""
    return [
        dataclasses.replace(r, robot=robot, kp=factor * r.kp, kd=factor * r.kd) for r in recordings
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("robots")


def recorded(folder, hidden):
    robot = pendulum(folder, 1.0)
    made = [
        recording(robot, swing(0.5, hz), f"kp{kp:g}_{hz:g}", kp, kd, 1.5, control_rate_hz=200.0)
        for kp, kd, hz in ((5.0, 0.3, 0.7), (20.0, 0.8, 0.9), (80.0, 2.0, 1.1), (20.0, 0.8, 1.2))
    ]
    return [measured(r, hidden, 1e-4, seed) for seed, r in enumerate(made)]


@pytest.fixture(scope="module")
def recordings(folder):
    return recorded(folder, HIDDEN[0])


def table_of(robot, recordings):
    """The candidates of a bare robot, and its sizes."""
    predictor, bare = Predictor(robot, recordings, threads=1), (Layout(()), np.zeros(0))
    model = sized(Model(robot), predictor)
    residual = predictor.samples.q - predictor.predict([Request(bare[0], bare[1][None])])[0][0]
    sections = linearised(predictor, *bare, measured_motion(predictor, *bare))
    effects = [e for e in model.known_effects(predictor.joints).values() if e.may_act(recordings)]
    read = read_off(predictor, sections, np.ones(len(residual), bool), bare, bare, effects)
    guesses = {e.name: first_guesses(e, model.sizes, 1) + read[e.name] for e in effects}
    rows = np.arange(len(residual))
    table = known_candidates(predictor, sections, bare, effects, guesses, residual, rows)
    return table, model.sizes


@pytest.fixture(scope="module")
def one(folder, recordings):
    return table_of(pendulum(folder, 1.0), recordings)


def found(robot, recordings):
    """Effects by name, with their values; no curve stands for one."""
    model = search(Model(robot), split(robot, recordings, threads=1)).model
    assert model.learned == ()
    return model.effects


@settings(deadline=None, max_examples=1, phases=PHASES)
@example(factor=1e-3)
@example(factor=1e3)
@given(factor=factors)
def test_candidates_answer_alike(folder, recordings, one, factor):
    robot = pendulum(folder, factor)
    other, sizes = table_of(robot, times(recordings, robot, factor))
    table, plain = one
    for name in SIZES:
        expected = factor ** POWERS.get(name, 1) * getattr(plain, name)
        np.testing.assert_allclose(getattr(sizes, name), expected, rtol=1e-6, err_msg=name)
    assert [c.key for c in other.candidates] == [c.key for c in table.candidates]
    for a, b in zip(table.candidates, other.candidates, strict=True):
        assert a.complexity == b.complexity
        for i, j in zip(a.constants, b.constants, strict=True):
            alike(other.columns[:, j], table.columns[:, i], a)
        by_name = {p.name: p for p in a.effect.parameters}
        for c, d in zip(a.columns, b.columns, strict=True):
            assert (c.parameter, c.joint) == (d.parameter, d.joint)
            parameter = by_name.get(c.parameter)
            unit = factor ** (power(parameter.unit) if parameter and not parameter.log else 0)
            pair = unit * other.columns[:, d.at], table.columns[:, c.at]
            alike(*pair, (a, c.parameter), rounding(table, a, c))
            np.testing.assert_allclose([d.lower, d.upper], [unit * c.lower, unit * c.upper], 1e-5)


def rounding(table, candidate, column):
    """What single precision of the response at a setting is in a difference over a step, in rad."""
    layout = Layout([Term(candidate.effect, candidate.joints)])
    keys = [(slot.parameter.name, slot.joint) for slot in layout.slots]
    u = np.array([candidate.setting.get(key, 0.0) for key in keys])
    (at,) = (i for i, (name, _) in enumerate(keys) if name == column.parameter)
    (step,) = steps_of(layout, [at], u)
    constant = np.abs(table.columns[:, list(candidate.constants)]).max()
    return np.finfo(np.float32).eps * constant / abs(step)


def alike(one, other, what, rounded=0.0):
    """Responses in rad, but for the single precision that torques have."""
    atol = 2e-3 * np.abs(other).max() + 2e-6 + 4 * rounded
    off = np.abs(one - other)
    # rounding lets teeth meet on either side of a tick
    assert np.mean(off > atol) < 0.02, what
    assert off.max() < 5 * atol, what


@pytest.fixture(scope="module", params=HIDDEN, ids="+".join)
def explained(folder, request):
    """What is hidden, its recordings, and what is found in them."""
    logs = recorded(folder, request.param)
    return request.param, logs, found(logs[0].robot, logs)


@settings(deadline=None, max_examples=1, phases=PHASES)
@example(factor=1e-3)
@example(factor=1e3)
@given(factor=factors)
def test_the_search_finds_the_same(folder, explained, factor):
    hidden, logs, plain = explained
    robot = pendulum(folder, factor)
    scaled = found(robot, times(logs, robot, factor))
    assert set(plain) == set(scaled) == set(hidden)
    for name in plain:
        for p in builtin()[name].parameters:
            number, other, truth = (
                one[name][p.name]["hinge"] if p.per_joint else one[name][p.name]
                for one in (plain, scaled, hidden)
            )
            assert number == pytest.approx(truth, rel=0.01)
            assert other == pytest.approx(factor ** power(p.unit) * number, rel=1e-3)
