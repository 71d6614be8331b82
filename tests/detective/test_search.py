"""The search on made recordings, and the command that shows what it found."""

import json
import re

import numpy as np
import pytest

from t2l.cli.main import main
from t2l.detective.data_split import split
from t2l.detective.explanation import explained
from t2l.detective.fit import Samples, fit_sets
from t2l.detective.fitted_set import Start
from t2l.detective.search import search
from t2l.diagnose.ranking import NOTHING_MISSING
from t2l.effects.law import FRICTION
from t2l.effects.term import Layout, Term
from t2l.identify.model import Model, read_model
from t2l.recordings.log import write_recording
from tests.diagnose.made import measured, pendulum, recording, swing, swings, two_pendulums

HIDDEN = {"coulomb_friction": {"torque": {"hinge": 0.05}}, "command_delay": {"delay": 0.02}}


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


def recorded(robot, effects=None, seed=0):
    """Four recordings of which one reports."""
    return swings(robot, effects, duration_s=2.0) + swings(robot, effects, duration_s=1.0)[1:2]


def test_two_effects_at_once_are_found_with_their_numbers(robot):
    found = search(Model(robot), split(robot, recorded(robot, HIDDEN), threads=1)).model
    assert set(found.effects) == set(HIDDEN)
    assert found.effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, rel=0.03)
    assert found.effects["command_delay"]["delay"] == pytest.approx(0.02, abs=5e-4)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        (
            "maxwell_slip_friction",
            {
                "torque_1": 0.1, "radius_1": 0.03, "torque_2": 0.1, "radius_2": 0.1,
                "torque_3": 0.1, "radius_3": 0.4,
            },
        ),
        # what needs fewer numbers keeps its name
        ("dahl_friction", {"coulomb": 0.15, "presliding": 0.03}),
        ("coulomb_friction", {"torque": 0.15}),
    ],
)  # fmt: skip
def test_what_bends_before_it_slips_is_told_from_what_does_so_bit_by_bit(robot, name, values):
    hidden = {name: {key: {"hinge": value} for key, value in values.items()}}
    gains = ((5.0, 0.3, 0.7), (20.0, 0.8, 0.9), (5.0, 0.3, 1.1), (20.0, 0.8, 0.8), (10.0, 0.5, 1.0))
    logs = [
        measured(recording(robot, swing(0.5, hz), f"{i}", kp, kd, 2.5), hidden, 1e-4, i)
        for i, (kp, kd, hz) in enumerate(gains)
    ]
    found = search(Model(robot), split(robot, logs[:4], logs[4:], threads=1)).model
    assert set(found.effects) == {name}
    for key, value in values.items():
        assert found.effects[name][key]["hinge"] == pytest.approx(value, rel=0.1), key


def test_friction_is_found_where_the_motor_is_at_its_limit_most_of_the_time(tmp_path):
    """There no small change of the torque moves anything."""
    limit = 'actuatorfrclimited="true" actuatorfrcrange="-0.35 0.35"'
    robot = pendulum(tmp_path, joint=f'armature="0.005" damping="0.02" {limit}')
    gains = ((20.0, 0.8, 0.7), (80.0, 1.0, 0.9), (320.0, 2.0, 1.1), (160.0, 2.0, 0.8))
    hidden = {"coulomb_friction": {"torque": {"hinge": 0.2}}}
    logs = [
        measured(recording(robot, swing(1.5, hz), f"kp{kp:g}", kp, kd, 2.0), hidden, 1e-4, seed)
        for seed, (kp, kd, hz) in enumerate(gains)
    ]
    found = search(Model(robot), split(robot, logs[:3], logs[3:], threads=1)).model
    assert set(found.effects) == set(hidden)
    assert found.effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.2, rel=0.01)


def test_what_says_as_much_with_fewer_numbers_takes_the_place_of_a_term(tmp_path):
    """Constant friction in the place of a drifting one, of which a first guess is far off."""
    robot = two_pendulums(tmp_path)
    hidden = {"coulomb_friction": {"torque": {"left": 0.2, "right": 0.03}}}
    commands = lambda t: np.stack([swing(0.5, 0.9)(t), swing(-0.4, 1.3)(t)], axis=1)  # noqa: E731
    logs = [
        measured(recording(robot, commands, kp=kp, duration_s=2.0), hidden, 1e-4, seed)
        for seed, kp in enumerate((20.0, 40.0, 30.0))
    ]
    model, data = Model(robot), split(robot, logs[:2], logs[2:], threads=1)
    layout = Layout([Term(model.known_effects(data.fitted.joints)["friction_drift"], (0, 1))])
    level = np.array([0.2, 0.03])
    u = layout.encode(
        {"friction_drift": {"at_start": level, "at_end": level, "time_constant": np.array([1.0])}}
    )
    whole = Samples(data.fitted, data.fitted, data.fitted, data.fitted_mask, data.folds)
    (drifting,) = fit_sets([Start(layout, u)], whole)
    found = search(model, data, resumed=(1, drifting)).model
    assert set(found.effects) == set(hidden)


def test_where_nothing_is_missing_nothing_is_looked_for(robot):
    explanation = explained(Model(robot), split(robot, recorded(robot), threads=1))
    assert explanation.verdict == NOTHING_MISSING
    assert [step.effects for step in explanation.steps] == [()]
    assert explanation.model.effects == {}


def test_what_has_no_name_that_is_known_is_a_curve(robot):
    few = Model(robot, without=("coulomb_friction", "dahl_friction", "directional_friction",
        "friction_drift", "load_dependent_friction", "lugre_friction", "maxwell_slip_friction",
        "stribeck_friction",
    ))  # fmt: skip
    hidden = {"coulomb_friction": HIDDEN["coulomb_friction"]}
    explanation = explained(few, split(robot, recorded(robot, hidden), threads=1))
    assert explanation.verdict == NOTHING_MISSING
    assert explanation.model.effects == {}
    (curve,) = explanation.model.learned
    assert curve.law.kind == FRICTION
    assert np.median(curve.torque) == pytest.approx(0.05, rel=0.03)
    assert explanation.steps[-1].test_rmse_rad < 1.1 * explanation.noise_floor_rad


def test_each_pair_of_gains_and_each_motion_that_recordings_share_is_left_out(robot):
    motions = [swing(0.5, 0.7), swing(0.5, 1.1), swing(0.3, 0.7)]
    stiff = (5.0, 20.0, 80.0)
    made = [
        measured(recording(robot, motion, f"kp{kp:g}_{i}", kp, 0.3, 1.0), {}, 1e-4, seed=i)
        for i, motion in enumerate(motions)
        for kp in stiff
    ]
    data = split(robot, made, made[:1], threads=1)
    of = data.fitted.samples.recording
    shared = of % len(stiff), of // len(stiff)  # gains, motion
    assert data.folds.shape == (len(of), 2)
    for way, same in zip(data.folds.T, shared, strict=True):
        assert np.array_equal(np.unique(way, return_inverse=True)[1], same)
    assert not set(data.folds[:, 0]) & set(data.folds[:, 1])


def test_recordings_that_share_neither_gains_nor_motion_are_left_out_alone(robot):
    data = split(robot, swings(robot, duration_s=1.0), swings(robot, duration_s=1.0)[:1], threads=1)
    assert np.array_equal(data.folds[:, 0], data.fitted.samples.recording)


@pytest.fixture
def at_home(robot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for log in recorded(robot, HIDDEN):
        name = f"{log.name}_{log.duration_s:g}"
        write_recording(log, tmp_path / "logs" / name)
    return tmp_path


def test_the_answer_is_written_with_its_page(at_home, capsys):
    main(["explain", "logs", "--out", "out"])
    said = capsys.readouterr().out
    assert "most likely" in said
    assert "Nothing more is missing." in said
    content = json.loads((at_home / "out/explanation.json").read_text())
    assert content["verdict"] == NOTHING_MISSING
    assert {row["effect"] for row in content["parameters"]} == set(HIDDEN)
    assert set(read_model(at_home / "out/model.yaml").effects) == set(HIDDEN)
    assert "adopted: nothing" not in (at_home / "out/model.yaml").read_text()
    page = (at_home / "out/report.html").read_text()
    assert re.search(r"2\s*(<[^>]*>\s*)*known effects added", page)
