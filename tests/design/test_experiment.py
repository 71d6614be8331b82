"""A pendulum's experiment: better than chance, safe, run by t2l record as it is written."""

import contextlib
import io
import json

import numpy as np
import pytest
import yaml

from t2l.cli.main import main
from t2l.design.d_optimal import exchange, log_det
from t2l.design.experiment import Wanted, design, motion_count
from t2l.design.identifiability import identifiability, of_log
from t2l.design.library import library, recording
from t2l.design.safety import SAFE, within_limits
from t2l.design.sensitivity import Sensitivity
from t2l.detective.data_split import split
from t2l.detective.ranking import diagnose
from t2l.diagnose.ranking import MISSING
from t2l.hardware.guard import Workspace
from t2l.hardware.limits import POSITION_MARGIN_RAD
from t2l.hardware.plan import check_simulated, read_plan, read_setup
from t2l.identify.model import Model
from t2l.identify.prediction import Predictor, Request
from t2l.recordings import read_recordings
from tests.design.made import COULOMB, LIMITS, configuration
from tests.diagnose.made import all_but, hold, swing, two_pendulums
from tests.diagnose.made import recording as made_recording

EFFECTS = ("coulomb_friction", "viscous_friction", "armature")


@pytest.fixture(scope="module")
def setup(tmp_path_factory):
    return read_setup(configuration(tmp_path_factory.mktemp("setup")))


@pytest.fixture(scope="module")
def model(setup):
    return Model(setup.robot.name)


@pytest.fixture(scope="module")
def effects(setup, model):
    known = {e.name: e for e in model.missing_effects(setup.robot.joints)}
    return [known[name] for name in EFFECTS]


def test_the_choice_beats_every_motion_alone_and_chance(setup, model, effects):
    wanted = Wanted(effects, total_s=9.0, motion_s=3.0, most_rad=0.5, noise_rad=1e-4)
    found = design(setup, model, wanted)
    assert len(found.chosen) == len({c.name for c in found.chosen}) == 3
    assert found.log_det > found.best_single
    assert found.log_det > found.random
    assert all(entry.told_together for entry in found.told.expected)
    assert max(found.peaks) <= 1.0


def test_an_exchange_finds_the_best_of_all_choices():
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(8, 2, 4)) * rng.uniform(0.1, 3, size=(8, 1, 1))
    information = columns.transpose(0, 2, 1) @ columns
    chosen = exchange(information, 3)
    everything = [
        log_det(information[[a, b, c]].sum(axis=0))
        for a in range(8) for b in range(a) for c in range(b)
    ]  # fmt: skip
    assert log_det(information[chosen].sum(axis=0)) == pytest.approx(max(everything))


def test_no_motion_leaves_a_margin_in_simulation(tmp_path):
    """The velocity limit binds here, and a box for the tool."""
    setup = read_setup(
        configuration(tmp_path, limits={**LIMITS, "velocity_rad_s": 1.0}, gains={"kp": 80, "kd": 1})
    )
    model = Model(setup.robot.name)
    box = Workspace((-0.08, -1, 0.0), (0.08, 1, 2))
    asked = library(setup, 2.0, 0.5)
    safe = within_limits(setup, model, asked, box)
    assert safe.candidates
    smaller = [c.amplitude_rad[0] < 0.49 for c in safe.candidates if "small" not in c.name]
    assert any(smaller)
    motions = [c.motion(setup) for c in safe.candidates]
    predictor = Predictor(model.robot, [recording(setup, m, 4) for m in motions])
    layout, u = model.vector(setup.robot.joints)
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    low, high = setup.robot.position_limit.T
    assert np.abs(dq).max() <= SAFE * 1.0
    assert (q > low + POSITION_MARGIN_RAD).all()
    assert (q < high - POSITION_MARGIN_RAD).all()
    # the tool is 0.25 m from the axis
    assert np.abs(0.25 * np.sin(q)).max() <= 0.08


def test_a_joint_that_stands_still_is_not_told(tmp_path):
    robot = two_pendulums(tmp_path)
    made = made_recording(
        robot,
        lambda t: np.stack([swing()(t), hold(0.0)(t)], axis=1),
        kp=20.0, kd=0.8, duration_s=2.0,
    )  # fmt: skip
    rng = np.random.default_rng(0)
    log = type(made)(**{**vars(made), "q": made.q_des + 1e-4 * rng.normal(size=made.q.shape)})
    model = Model(robot)
    known = {e.name: e for e in model.missing_effects(log.joints)}
    told = of_log(model, [log], [known[name] for name in EFFECTS])
    by_joint = {(e.effect, e.joint): e.told for e in told.expected}
    assert all(by_joint[name, "left"] for name in EFFECTS)
    assert not any(by_joint[name, "right"] for name in EFFECTS)
    assert "This log cannot tell armature (inertia) of right" in told.sentences("This log")


def test_a_delay_and_a_clock_offset_look_alike_without_gravity(setup, model):
    known = {e.name: e for e in model.missing_effects(setup.robot.joints)}
    pair = [known["command_delay"], known["clock_offset"], known["coulomb_friction"]]
    motions = [c.motion(setup) for c in library(setup, 2.0, 0.3) if c.shape == "slow_multisine"]
    recordings = [recording(setup, m) for m in motions]
    sensitivity = Sensitivity(model, pair, recordings)
    found = identifiability(sensitivity, recordings).confounded
    assert {found[0].first, found[0].second} == {"command delay", "clock offset"}
    assert found[0].correlation > 0.98


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A folder with a plan and what `t2l record` made of it with a virtual robot."""
    folder = tmp_path_factory.mktemp("planned")
    tell = ["--tell", ",".join(EFFECTS), "--total-s", "4.5", "--motion-s", "1.5"]
    main(["plan", str(configuration(folder)), *tell, "--out", str(folder / "plan")])
    main(["record", str(folder / "plan/plan.yaml"), "--out", str(folder / "logs")])
    return folder


def test_a_plan_is_recorded_as_it_is(planned):
    numbers = json.loads((planned / "plan/plan.json").read_text())
    assert numbers["log_det"]["chosen"] > numbers["log_det"]["mean_of_random_choices"]
    assert (planned / "plan/figures/motions.png").stat().st_size > 0
    names = [motion.name for motion in read_plan(planned / "plan/plan.yaml").motions]
    assert [motion["name"] for motion in numbers["motions"]] == names
    assert sorted(path.stem for path in (planned / "logs").glob("*.csv")) == sorted(names)


def test_the_recordings_of_a_plan_name_the_planted_effect(planned):
    recordings = read_recordings([planned / "logs"])
    model = Model(recordings[0].robot, without=all_but(*EFFECTS))
    found = diagnose(model, split(model.robot, recordings, threads=1))
    best = found.ranking[0]
    assert (found.verdict, best.effect.name) == (MISSING, "coulomb_friction")
    assert best.layout.theta(best.u)[0] == pytest.approx(COULOMB, rel=0.1)


@pytest.fixture(scope="module")
def among_all(planned):
    """What diagnose says and writes of a plan's recordings."""
    with contextlib.redirect_stdout(io.StringIO()) as said:
        main(["diagnose", str(planned / "logs"), "--out", str(planned / "found")])
    return said.getvalue(), json.loads((planned / "found/diagnosis.json").read_text())


@pytest.mark.slow
def test_what_a_plans_log_cannot_tell_is_said(among_all):
    assert "This log cannot tell payload (com_y)" in among_all[0]


@pytest.mark.slow
@pytest.mark.xfail(
    strict=True,
    reason="left out, one recording of two does not tell how far bristles bend: Dahl's friction "
    "leaves 0.413 mrad as Coulomb's does, though fitted to both it leaves 0.326 and not 0.408",
)
def test_among_all_effects_it_is_named_too(among_all):
    # the virtual robot has bristles without a breakaway torque, as Dahl's
    assert among_all[1]["ranking"][0]["effect"] == "dahl_friction"


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        ({}, ["--tell", "coulomb_frictoin"], "did you mean coulomb_friction"),
        ({}, ["--motion-s", "0.1"], "--motion-s: found 0.1; allowed: 1 to"),
        ({"gains": None}, [], "key gains: found nothing"),
        ({"limits": None}, [], "key limits.velocity_rad_s: found nothing, and pendulum.xml"),
        ({}, ["--workspace=5,5,5,6,6,6"], "--workspace: found a box that the tool leaves at the"),
        ({}, ["--total-s", "1"], "--total-s: found 1 with --motion-s 6; allowed: 18 to 600"),
        ({}, ["--motion-s", "1"], r"--total-s: found 200 with --motion-s 1; allowed: 3 to 100"),
        ({"excitation": {"kind": "hold"}}, [], "setup.yaml: key excitation: found it; allowed: no"),
        ({"motions": [{}]}, [], "setup.yaml: key motions: found it; allowed: none"),
        ({"command_rate_hz": 2}, [], "--motion-s: found 6 with command_rate_hz 2; allowed: 10 to"),
        ({"command_rate_hz": 0.01}, [], "key command_rate_hz: found 0.01; allowed: from 0.033 up"),
        ({"gains": {"kp": 20, "kd": 400}}, [], "kp20_kd400: hinge: found .* rings by itself"),
    ],
    ids=str,
)  # fmt: skip
def test_mistakes_are_named(tmp_path, change, options, message):
    path = configuration(tmp_path, **change)
    total = [] if "--total-s" in options else ["--total-s", "200"]
    with pytest.raises(SystemExit, match=message):
        main(["plan", str(path), *options, *total, "--out", str(tmp_path / "out")])
    # before anything is simulated
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "box",
    ["nan,-1,0,1,1,2", "-1,-1,0,1,1", "-1,-1,0,x,1,2", "1,1,2,-1,-1,0", "-inf,-1,0,1,1,2", ""],
)
def test_a_box_that_is_none_is_named_with_its_option(tmp_path, capsys, box):
    path = configuration(tmp_path)
    with pytest.raises(SystemExit):
        main(["plan", str(path), f"--workspace={box}", "--out", str(tmp_path / "out")])
    said = capsys.readouterr().err.splitlines()[-1]
    assert f"argument --workspace: found '{box}'; allowed: x,y,z,x,y,z, six finite numbers" in said


def test_the_time_is_not_exceeded(setup, effects):
    for total_s, motion_s, count in ((9, 3, 3), (11.9, 3, 3), (12, 3, 4), (0.3 * 10, 0.1 * 10, 3)):
        wanted = Wanted(effects, total_s, motion_s, most_rad=0.5, noise_rad=1e-4)
        assert motion_count(setup, wanted) == count


def test_a_plan_by_a_model_that_damps_more_is_one_that_t2l_record_takes(tmp_path):
    """The model has friction enough to hide a resonance that the MJCF alone would show."""
    setup = read_setup(configuration(tmp_path, gains={"kp": 20, "kd": 0.005}))
    model = Model(setup.robot.name, {"viscous_friction": {"damping": {"hinge": 1.0}}})
    wild = [c for c in library(setup, 4.0, 2.0) if c.shape in ("chirp", "fast_multisine")]
    safe = within_limits(setup, model, wild)
    assert safe.candidates
    check_simulated(setup, [c.motion(setup) for c in safe.candidates])


def test_a_curve_of_the_model_acts_in_the_simulation_too(tmp_path):
    path = configuration(tmp_path)
    curve = {
        "kind": "friction", "joint": "hinge", "follows": "temperature", "of": "hinge",
        "at": [20, 40], "torque": [0.1, 0.05],
    }  # fmt: skip
    model = {"robot": "pendulum.xml", "effects": {}, "learned": [curve]}
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(model))
    arguments = ["plan", str(path), "--model", str(tmp_path / "model.yaml")]
    # no temperature is known beforehand
    with pytest.raises(SystemExit, match="it follows the column temperature"):
        main([*arguments, "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out/plan.yaml").exists()
