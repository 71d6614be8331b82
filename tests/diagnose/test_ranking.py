import dataclasses
import json

import numpy as np
import pytest
from benchmarks.hidden_effects import effects as hidden
from benchmarks.hidden_effects.cases import ROBOTS
from benchmarks.hidden_effects.generator import record

from t2l.detective.data_split import split
from t2l.detective.ranking import diagnose
from t2l.diagnose.artefacts import write_diagnosis
from t2l.diagnose.candidate import Candidate, mark_ties, rank
from t2l.diagnose.ranking import MISSING, NOTHING_MISSING, UNEXPLAINED, adopt
from t2l.diagnose.wording import why
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.errors import T2LError
from t2l.identify.block_bootstrap import Improvement
from t2l.identify.model import Model, read_model
from t2l.recordings import Recording
from tests.diagnose.made import (
    all_but,
    measured,
    pendulum,
    recording,
    swing,
    swings,
    two_pendulums,
)

FEW = ("coulomb_friction", "viscous_friction", "armature", "command_delay", "torque_offset")
COULOMB = {"coulomb_friction": {"torque": {"hinge": 0.05}}}
FAST = {"control_rate_hz": 250.0, "duration_s": 1.0}


def only(robot, *names, effects=None):
    """A model that may lack these effects alone."""
    return Model(robot, effects or {}, without=all_but(*names or FEW, *effects or {}))


def shared_out(robot, recordings):
    return split(robot, recordings, threads=1)


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def rubbing(robot):
    """Recordings of a pendulum that rubs."""
    return shared_out(robot, swings(robot, COULOMB, **FAST))


@pytest.fixture(scope="module")
def found(robot, rubbing):
    return diagnose(only(robot), rubbing)


def test_hidden_friction_is_named_first(robot, rubbing, found):
    assert found.verdict == MISSING
    best = found.ranking[0]
    assert best.effect.name == "coulomb_friction"
    assert best.justified
    assert best.layout.theta(best.u) == pytest.approx([0.05], rel=0.05)
    low, high = best.uncertainty.interval(0)
    assert low < 0.05 < high
    assert best.improvement.ci95[0] < best.improvement.fraction < best.improvement.ci95[1]
    assert {c.effect.name for c in found.ranking} == set(FEW)
    assert found.validation_rmse_rad > 3 * found.noise_floor_rad
    assert best.validation_rmse_rad < 1.1 * found.noise_floor_rad


def test_once_adopted_nothing_is_missing(robot, rubbing, found):
    model = adopt(found, "coulomb_friction")
    assert model.effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, rel=0.05)
    again = diagnose(model, rubbing)
    assert again.verdict == NOTHING_MISSING
    # what is adopted is no candidate any more
    assert {c.effect.name for c in again.ranking} == set(FEW) - {"coulomb_friction"}


def test_the_same_recordings_give_the_same_diagnosis(robot, rubbing, found):
    again = diagnose(only(robot), rubbing)
    assert [c.effect.name for c in again.ranking] == [c.effect.name for c in found.ranking]
    for first, second in zip(found.ranking, again.ranking, strict=True):
        np.testing.assert_array_equal(first.u, second.u)
        assert first.improvement == second.improvement


def test_a_clean_recording_lacks_nothing(robot):
    clean = shared_out(robot, swings(robot, **FAST))
    assert diagnose(only(robot), clean).verdict == NOTHING_MISSING


def test_what_no_candidate_explains_stays_unexplained(robot, rubbing):
    found = diagnose(only(robot, "torque_offset"), rubbing)
    assert found.verdict == UNEXPLAINED
    assert not found.ranking[0].justified


def test_without_candidates_an_error_is_unexplained(robot, rubbing):
    none = {"viscous_friction": {"damping": {"hinge": 0.0}}}
    found = diagnose(only(robot, *none, effects=none), rubbing)
    assert found.verdict == UNEXPLAINED
    assert found.ranking == []


def test_the_joint_that_rubs_is_found(tmp_path):
    robot = two_pendulums(tmp_path)
    friction = Model(robot, {"coulomb_friction": {"torque": {"right": 0.06}}})

    def both(hz):
        return lambda t: np.stack([swing(0.5, hz)(t), swing(-0.4, 1.3 * hz)(t)], axis=1)

    recordings = [
        measured(
            recording(robot, both(hz), str(kp), kp, kd, 1.2, control_rate_hz=250.0),
            noise_rad=1e-4, seed=int(kp), model=friction,
        )
        for kp, kd, hz in ((5.0, 0.3, 0.7), (20.0, 0.8, 0.9), (60.0, 1.8, 1.1))
    ]  # fmt: skip
    model = only(robot, "coulomb_friction", "viscous_friction", "armature")
    best = diagnose(model, shared_out(robot, recordings)).ranking[0]
    assert best.effect.name == "coulomb_friction"
    assert best.term.joints == (1,)
    assert best.layout.theta(best.u) == pytest.approx([0.06], rel=0.05)


def test_an_independent_machines_friction_is_named():
    """Of a machine whose physics, controller and friction are not t2l's."""
    robot, recordings = ROBOTS["pendulum"], []
    for seed, (kp, kd) in enumerate(robot.setup.gains):
        hz = 0.7 + 0.2 * seed
        frame = record(
            robot.mjcf, robot.joints, kp, kd, lambda t, hz=hz: swing(0.6, hz)(t)[:, None],
            duration_s=1.2, sample_rate_hz=100, physics_rate_hz=4000, control_rate_hz=500,
            hidden=[hidden.CoulombFriction(0.05)], encoder_noise_rad=1e-4,
            rng=np.random.default_rng(seed),
        )  # fmt: skip
        recordings.append(
            Recording(
                name=f"kp{kp:g}", path=None, robot=str(robot.mjcf), joints=robot.joints,
                kp=np.array([kp]), kd=np.array([kd]), command_rate_hz=50.0,
                control_rate_hz=500.0, gravity_compensation=False,
                time=frame["time"].to_numpy(), q_des=frame[["q_des.hinge"]].to_numpy(),
                q=frame[["q.hinge"]].to_numpy(),
            )
        )  # fmt: skip
    found = diagnose(only(str(robot.mjcf)), shared_out(str(robot.mjcf), recordings))
    assert found.verdict == MISSING
    assert found.ranking[0].effect.name == "coulomb_friction"
    assert found.ranking[0].layout.theta(found.ranking[0].u) == pytest.approx([0.05], rel=0.05)


# --------------------------------------------------------------------------------- the ranking


def candidate(name, heldout, fraction=0.5, joints=(0,)):
    effect = builtin()[name]
    layout = Layout([Term(effect, joints)])
    return Candidate(
        effect=effect,
        layout=layout,
        u=np.zeros(len(layout)),
        train_rmse_rad=heldout,
        validation_rmse_rad=heldout,
        improvement=Improvement(fraction, (fraction - 0.1, fraction + 0.1), fraction - 0.15),
    )


def names(candidates):
    return [c.effect.name for c in candidates]


def test_less_error_ranks_first_and_fewer_parameters_among_equals():
    stribeck, coulomb = candidate("stribeck_friction", 1.00), candidate("coulomb_friction", 1.02)
    delay = candidate("command_delay", 1.5)
    assert names(rank([delay, stribeck, coulomb])) == [
        "coulomb_friction", "stribeck_friction", "command_delay",
    ]  # fmt: skip
    clearly_better = candidate("stribeck_friction", 0.9)
    assert names(rank([coulomb, clearly_better]))[0] == "stribeck_friction"


def test_what_only_leaves_the_noise_is_tied_and_the_simplest_first():
    candidates = [candidate("stribeck_friction", 1.0), candidate("torque_offset", 1.08)]
    assert names(rank(candidates)) == ["stribeck_friction", "torque_offset"]
    ranking = rank(candidates, quiet=1.1)
    assert names(ranking) == ["torque_offset", "stribeck_friction"]
    mark_ties(ranking, quiet=1.1)
    assert ranking[0].tied_with == ["stribeck_friction"]


def test_what_only_the_linear_model_promises_is_never_first_and_ties_with_nothing():
    promised, simulated = candidate("armature", 0.9), candidate("torque_offset", 1.0)
    promised.simulated = False
    ranking = rank([promised, simulated])
    assert names(ranking) == ["torque_offset", "armature"]
    mark_ties(ranking, quiet=2.0)
    assert ranking[0].tied_with == []
    said = why(promised, {}, {})
    assert said.endswith("so it was not simulated.")
    assert "unsure" not in said


def test_explanations_as_good_as_the_first_are_tied_unless_one_contains_the_other():
    ranking = [
        candidate("coulomb_friction", 1.0),
        candidate("stribeck_friction", 1.01),
        candidate("load_dependent_friction", 1.02),
        candidate("armature", 1.2),
    ]
    mark_ties(ranking)
    assert [c.tied_with for c in ranking] == [
        ["load_dependent_friction"], [], ["coulomb_friction"], [],
    ]  # fmt: skip


def test_what_is_not_justified_ties_with_nothing():
    ranking = [candidate("armature", 1.0, 0.01), candidate("torque_offset", 1.0, 0.01)]
    mark_ties(ranking)
    assert [c.tied_with for c in ranking] == [[], []]


def test_what_no_recording_can_tell_apart_is_tied(robot):
    """A weak motor and smaller gains, where the motor carries no gravity."""
    weak = {"torque_constant": {"factor": {"hinge": 0.8}}}
    data = shared_out(robot, swings(robot, weak, **FAST))
    model = only(robot, "controller_gains", "torque_constant", "command_delay")
    found = diagnose(model, data)
    assert names(found.ranking)[0] == "torque_constant"
    assert found.ranking[0].tied_with == ["controller_gains"]


# -------------------------------------------------------------------------------- what is written


@pytest.fixture(scope="module")
def written(robot, rubbing, found, tmp_path_factory):
    folder = tmp_path_factory.mktemp("written")
    write_diagnosis(found, rubbing.fitted, rubbing.test, folder)
    return folder


def test_each_candidate_can_be_adopted_from_its_file(found, written):
    assert sorted(p.stem for p in (written / "models").glob("*.yaml")) == sorted(FEW)
    for name in FEW:
        adopted = adopt(found, name)
        again = read_model(written / "models" / f"{name}.yaml")
        assert again.robot == adopted.robot
        (values,), (expected,) = (m.effects[name].values() for m in (again, adopted))
        assert values == pytest.approx(expected, rel=1e-5)


def test_the_diagnosis_says_what_was_found(found, written):
    def fail(constant):
        raise AssertionError(f"{constant} is not JSON")

    text = (written / "diagnosis.json").read_text()
    content = json.loads(text, parse_constant=fail)
    assert content["verdict"] == MISSING
    assert [c["effect"] for c in content["ranking"]] == names(found.ranking)
    best = content["ranking"][0]
    assert best["parameters"]["hinge.torque"]["unit"] == "N·m"
    low, high = best["parameters"]["hinge.torque"]["ci95"]
    assert low < best["parameters"]["hinge.torque"]["value"] < high
    assert "Coulomb friction" in content["sentence"]
    assert set(content["training_recordings"]).isdisjoint(content["test_recordings"])
    for entry in content["ranking"]:
        assert entry["why"].endswith(".")


def test_a_later_diagnosis_leaves_no_models_of_an_earlier_one(robot, rubbing, found, tmp_path):
    """What is no candidate any more cannot be adopted from the folder."""
    parts = rubbing.fitted, rubbing.test
    write_diagnosis(found, *parts, tmp_path)
    again = diagnose(only(robot, "viscous_friction"), rubbing)
    write_diagnosis(again, *parts, tmp_path)
    assert [p.stem for p in (tmp_path / "models").glob("*.yaml")] == ["viscous_friction"]


def test_recordings_of_a_perfect_model_without_noise_can_be_written(robot, tmp_path):
    """Their error is zero to rounding: nothing is missing, and the JSON is JSON."""
    exact = shared_out(robot, swings(robot, noise_rad=0.0, **FAST))
    found = diagnose(only(robot, "viscous_friction", "command_delay"), exact)
    assert found.verdict == NOTHING_MISSING
    write_diagnosis(found, exact.fitted, exact.test, tmp_path)
    assert "NaN" not in (tmp_path / "diagnosis.json").read_text()


def test_a_model_that_runs_away_is_told(robot, rubbing):
    wild = [dataclasses.replace(r, kd=np.array([100.0])) for r in rubbing.fitted.recordings]
    with np.errstate(all="ignore"), pytest.raises(T2LError, match=wild[0].name):
        diagnose(only(robot, "viscous_friction"), shared_out(robot, wild))
