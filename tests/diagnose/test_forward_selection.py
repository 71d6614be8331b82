import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from t2l.diagnose import forward_selection
from t2l.diagnose.evidence import gather
from t2l.diagnose.explanation import as_json, write_explanation
from t2l.diagnose.forward_selection import explain
from t2l.diagnose.ranking import NOTHING_MISSING, UNEXPLAINED
from t2l.effects.registry import builtin
from t2l.identify.model import Model, read_model
from tests.diagnose.made import pendulum, recording, swings, two_pendulums
from tests.effects.test_registry import RUBBER

HIDDEN = {
    "coulomb_friction": {"torque": {"hinge": 0.05}},
    "command_delay": {"delay": 0.02},
}


FEW = {*HIDDEN, "armature", "torque_offset", "viscous_friction"}


def few(robot, *rest):
    """A model that knows few effects, as what is tested here takes several explanations."""
    return Model(robot, *rest, without=tuple(set(builtin()) - FEW))


class Interrupted(Exception):  # noqa: N818
    """What a person does with Ctrl-C."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return pendulum(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def recordings(robot):
    # a real machine has no steps: what is adopted needs finer ones than the model as it came
    return swings(robot, HIDDEN, duration_s=1.0, control_rate_hz=125.0, substeps=8)


def until(words):
    """Progress that interrupts when it is told `words`, and what it was told."""
    told = []

    def progress(what, fraction):
        told.append(what)
        if words in what:
            raise Interrupted

    return progress, told


def files(folder: Path):
    return {p: (p.stat().st_mtime_ns, p.read_bytes()) for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def interrupted(robot, recordings, tmp_path_factory):
    """A run that was stopped in its second step, went on, and the first step in between."""
    folder = tmp_path_factory.mktemp("interrupted")
    evidence = gather(robot, recordings)
    progress, _ = until("step 2: fitting")
    with pytest.raises(Interrupted):
        explain(few(robot), evidence, folder, progress)
    between = files(folder / "steps" / "0")
    progress, told = until("never")
    explanation = explain(few(robot), evidence, folder, progress)
    return folder, between, told, explanation


def test_what_is_hidden_is_adopted_and_nothing_more(interrupted):
    *_, explanation = interrupted
    assert explanation.steps[0].effects == ()
    assert {name for step in explanation.steps for name in step.effects} == set(HIDDEN)
    assert explanation.verdict == NOTHING_MISSING
    errors = [step.validation_rmse_rad for step in explanation.steps]
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.5 * errors[1]
    effects = explanation.model.effects
    assert set(effects) == set(HIDDEN)
    assert effects["coulomb_friction"]["torque"]["hinge"] == pytest.approx(0.05, rel=0.1)
    assert effects["command_delay"]["delay"] == pytest.approx(0.02, rel=0.1)


def test_a_finished_step_is_kept(interrupted):
    folder, between, told, _ = interrupted
    assert between
    assert files(folder / "steps" / "0") == between
    assert told[0] == "step 1: kept from before"
    assert not any(what.startswith("step 1") for what in told[1:])
    assert any(what.startswith("step 2: fitting") for what in told)


def test_it_ends_as_if_it_had_never_stopped(interrupted, robot, recordings, tmp_path):
    *_, explanation = interrupted
    straight = explain(few(robot), gather(robot, recordings), tmp_path)
    assert as_json(straight) == as_json(explanation)
    assert straight.model == explanation.model


def test_once_finished_nothing_is_computed_again(interrupted, robot, recordings):
    folder, *_, explanation = interrupted
    before = files(folder)
    again = explain(few(robot), gather(robot, recordings), folder)
    assert as_json(again) == as_json(explanation)
    assert again.model == explanation.model
    assert files(folder) == before


def test_the_story_and_the_model_are_written(interrupted, tmp_path):
    *_, explanation = interrupted
    write_explanation(explanation, tmp_path)
    content = json.loads((tmp_path / "explanation.json").read_text())
    assert {name for step in content["steps"] for name in step["effects"]} == set(HIDDEN)
    model = read_model(tmp_path / "model.yaml")
    assert model.robot == explanation.model.robot
    assert set(model.effects) == set(HIDDEN)


def test_a_step_that_leads_back_ends_the_search(robot, recordings, tmp_path, monkeypatch):
    """What is superfluous without its partner is taken back at once, and would come again."""
    first = few(robot, {"coulomb_friction": HIDDEN["coulomb_friction"]})
    monkeypatch.setattr(
        forward_selection, "simplify", lambda grown, evidence: (first, ["command_delay"])
    )
    progress, told = until("never")
    explanation = explain(first, gather(robot, recordings), tmp_path, progress)
    assert not any(what.startswith("step 2") for what in told)
    assert (explanation.verdict, len(explanation.steps)) == (UNEXPLAINED, 1)
    assert "no known effect removes it" in explanation.sentence
    assert explanation.model == first
    (kept,) = [json.loads(p.read_text()) for p in tmp_path.glob("steps/0/diagnosis.json")]
    assert not kept["ranking"][0]["justified"]
    assert "taken back" in kept["ranking"][0]["why"]
    before = files(tmp_path)
    again = explain(first, gather(robot, recordings), tmp_path)
    assert as_json(again) == as_json(explanation)
    assert files(tmp_path) == before


def test_an_effect_that_grows_to_another_joint_leads_to_no_model_before(tmp_path):
    robot, torque = two_pendulums(tmp_path), {"left": 0.1, "right": 0.2}
    evidence = gather(robot, [recording(robot, lambda t: np.zeros((len(t), 2)))])
    one, both = (
        forward_selection._terms(Model(robot, {"coulomb_friction": {"torque": on}}), evidence)
        for on in ({"left": 0.1}, torque)
    )
    assert one != both


def recomputed(folder, model, recordings, substeps=1):
    """Whether the first step is begun anew."""
    progress, told = until("step")
    with pytest.raises(Interrupted):
        explain(model, gather(model.robot, recordings, substeps=substeps), folder, progress)
    return told[0] != "step 1: kept from before"


def test_the_same_input_is_not_computed_again(interrupted, robot, recordings):
    assert not recomputed(interrupted[0], few(robot), recordings)


@pytest.mark.parametrize(
    "change",
    [
        {"q": lambda r: r.q + 1e-6},
        {"q_des": lambda r: r.q_des + 1e-6},
        {"kp": lambda r: r.kp * 1.01},
        {"kd": lambda r: r.kd * 1.01},
        {"control_rate_hz": lambda r: 126.0},
        {"gravity_compensation": lambda r: True},
        {"dq": lambda r: np.full_like(r.q, 0.1)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_another_recording_is_computed_anew(interrupted, robot, recordings, change):
    ((key, value),) = change.items()
    changed = [dataclasses.replace(r, **{key: value(r)}) for r in recordings]
    assert recomputed(interrupted[0], few(robot), changed)


def test_another_model_is_computed_anew(interrupted, robot, recordings):
    model = Model(robot, {"torque_offset": {"torque": {"hinge": 0.001}}})
    assert recomputed(interrupted[0], model, recordings)
    assert recomputed(interrupted[0], few(robot), recordings, substeps=2)


def test_an_edited_mjcf_is_computed_anew(interrupted, robot, recordings):
    path = Path(robot)
    text = path.read_text()
    try:
        path.write_text(text.replace('mass="0.5"', 'mass="0.6"'))
        assert recomputed(interrupted[0], few(robot), recordings)
    finally:
        path.write_text(text)


def test_an_edited_effect_is_computed_anew(robot, recordings, tmp_path):
    """Whether it was given as a file or in a folder."""
    file, folder = tmp_path / "cord.py", tmp_path / "mine"
    folder.mkdir()
    (folder / "rubber.py").write_text(RUBBER)
    file.write_text(RUBBER.replace('"rubber"', '"cord"'))
    model = few(robot, {}, (file, folder))
    progress, _ = until("step 2")
    with pytest.raises(Interrupted):
        explain(model, gather(robot, recordings), tmp_path / "out", progress)
    assert not recomputed(tmp_path / "out", model, recordings)
    for path in (file, folder / "rubber.py"):
        text = path.read_text()
        path.write_text(text.replace("-= values", "-= 2 * values"))
        assert recomputed(tmp_path / "out", model, recordings), path
        path.write_text(text)


def test_a_step_whose_diagnosis_was_cut_short_is_computed_anew(
    interrupted, robot, recordings, tmp_path
):
    folder = interrupted[0]
    for part in ("diagnosis.json", "fingerprint"):
        where = tmp_path / part / "steps" / "0"
        where.mkdir(parents=True)
        for name in ("diagnosis.json", "fingerprint"):
            text = (folder / "steps" / "0" / name).read_text()
            (where / name).write_text(text[: len(text) // 2] if name == part else text)
        assert recomputed(tmp_path / part, few(robot), recordings)


DAMAGES = {
    "list": lambda step: (step / "diagnosis.json").write_text("[]"),
    "empty object": lambda step: (step / "diagnosis.json").write_text("{}"),
    "bytes": lambda step: (step / "diagnosis.json").write_bytes(b"\xff\x00"),
    "folder": lambda step: (step / "fingerprint").unlink() or (step / "fingerprint").mkdir(),
    "no ranking": lambda step: (step / "diagnosis.json").write_text(
        json.dumps({**json.loads((step / "diagnosis.json").read_text()), "ranking": []})
    ),
    "odd error": lambda step: (step / "diagnosis.json").write_text(
        json.dumps({**json.loads((step / "diagnosis.json").read_text()), "baseline": None})
    ),
    "name that leads out": lambda step: (step / "diagnosis.json").write_text(
        (step / "diagnosis.json").read_text().replace('"effect": "', '"effect": "../')
    ),
    "no models": lambda step: shutil.rmtree(step / "models"),
    "broken models": lambda step: [p.write_text("{") for p in step.glob("models/*")],
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_step_that_cannot_be_used_is_computed_anew(
    interrupted, robot, recordings, tmp_path, damage
):
    shutil.copytree(interrupted[0] / "steps", tmp_path / "steps")
    DAMAGES[damage](tmp_path / "steps" / "0")
    assert recomputed(tmp_path, few(robot), recordings)


@pytest.mark.parametrize("content", ["[]", "{}", "", '{"fingerprint": 1, "dropped": 2}', "\0"])
def test_what_was_adopted_is_simplified_anew_if_it_cannot_be_used(
    interrupted, robot, recordings, tmp_path, content
):
    folder, *_, explanation = interrupted
    shutil.copytree(folder / "steps", tmp_path / "steps")
    (tmp_path / "steps" / "0" / "adopted.json").write_text(content)
    (tmp_path / "steps" / "1" / "model.yaml").write_text("robot: [")
    progress, told = until("never")
    again = explain(few(robot), gather(robot, recordings), tmp_path, progress)
    assert all("kept from before" in what for what in told)
    assert as_json(again) == as_json(explanation)
    assert again.model.effects == explanation.model.effects


def test_only_models_of_the_diagnosis_before_are_removed(interrupted, robot, recordings, tmp_path):
    shutil.copytree(interrupted[0] / "steps" / "0", step := tmp_path / "steps" / "0")
    content = json.loads((step / "diagnosis.json").read_text())
    content["ranking"].append({"effect": "of_before"})
    (step / "diagnosis.json").write_text(json.dumps(content))
    (step / "fingerprint").write_text("of another")
    for name in ("of_before.yaml", "mine.yaml", "notes.txt"):
        (step / "models" / name).write_text("mine")
    progress, _ = until("step 2")
    with pytest.raises(Interrupted):
        explain(few(robot), gather(robot, recordings), tmp_path, progress)
    left = {path.name for path in (step / "models").iterdir()}
    ranked = {entry["effect"] for entry in content["ranking"]} - {"of_before"}
    assert left == {"mine.yaml", "notes.txt", *(f"{name}.yaml" for name in ranked)}
    assert (step / "models" / "mine.yaml").read_text() == "mine"
