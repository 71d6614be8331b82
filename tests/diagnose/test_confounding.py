"""One pair of gains: a wrong Kp moves a joint as another inertia and damping would."""

import dataclasses

import pytest

from t2l.design.collinearity import Rival
from t2l.detective.data_split import split
from t2l.diagnose.candidate import Candidate
from t2l.diagnose.confounded import Confounded, as_json, members, sentences
from t2l.diagnose.confounding import confounded_beforehand
from t2l.effects.registry import builtin
from t2l.identify.model import Model
from tests.diagnose.made import measured, recording, spinner, swing

HIDDEN = {
    "armature": {"inertia": {"hinge": 0.004}},
    "viscous_friction": {"damping": {"hinge": 0.03}},
}
GAINS = {"controller_gains": {"kp_factor": {"hinge": 0.9}, "kd_factor": {"hinge": 0.934}}}
TITLES = {name: effect.title for name, effect in builtin().items()}


def fitted(robot, effects, *gains):
    """What is fitted of two motions under each pair of gains; gravity does not load the joint."""
    made = [
        recording(robot, swing(0.5, hz), f"{kp}_{hz}", kp, kd, duration_s=1.5)
        for kp, kd in gains
        for hz in (0.7, 1.3)
    ]
    logs = [measured(r, effects, 1e-4, seed) for seed, r in enumerate(made)]
    data = split(robot, logs, threads=1)
    return data.fitted, data.fitted_mask


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    return spinner(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def one_gain(robot):
    return fitted(robot, HIDDEN, (20.0, 0.8))


@pytest.fixture(scope="module")
def three_gains(robot):
    return fitted(robot, HIDDEN, (5.0, 0.3), (20.0, 0.8), (80.0, 2.0))


def sets_of(found, effect):
    return [set(r.effects) for entry in found if entry.effect == effect for r in entry.rivals]


def test_under_one_pair_of_gains_inertia_and_damping_are_not_told_from_gains(robot, one_gain):
    found = confounded_beforehand(Model(robot), *one_gain)
    assert {"armature", "viscous_friction"} in sets_of(found, "controller_gains")
    said = sentences(found, builtin(), one_gain[0].recordings)
    first = next(
        s
        for s in said
        if s.startswith(f"These recordings cannot tell {TITLES['controller_gains']}")
    )
    assert TITLES["armature"] in first or "more" in first
    assert "All of them have one pair of gains (Kp, Kd): record others too." in said
    assert "--tell" in said[-1]
    assert "controller_gains" in said[-1]


def test_several_pairs_of_gains_tell_them_apart(robot, three_gains):
    found = confounded_beforehand(Model(robot), *three_gains)
    assert not sets_of(found, "controller_gains")
    assert not any("controller_gains" in names for names in sets_of(found, "armature"))


def test_where_nothing_is_missing_nothing_is_said(robot):
    assert confounded_beforehand(Model(robot), *fitted(robot, {}, (20.0, 0.8))) == []


def test_what_is_confounded_is_never_certain():
    names = [field.name for field in dataclasses.fields(Candidate)]
    candidate = Candidate(**dict.fromkeys(names[:6]), chosen_share=1.0)
    assert candidate.certain
    candidate.confounded = Confounded("armature", (Rival(("payload",), 20.0, 1.0),))
    assert candidate.certain is False


def test_words_name_a_shared_partner_once_and_each_pair_of_effects_once():
    pairs = [("a", "x"), ("a", "y"), ("b", "x"), ("a", "z"), ("a", "w")]
    entry = Confounded("e", tuple(Rival(pair, 20.0, 1.0) for pair in pairs))
    assert entry.from_what({}) == "a together with x, y, z or 1 more; b together with x"
    both = [
        Confounded("armature", (Rival(("payload",), 20.0, 1.0),), more_missing=True),
        Confounded("payload", (Rival(("armature",), 20.0, 1.0),)),
    ]
    said = sentences(both, builtin(), [])
    assert said[0] == "These recordings cannot tell armature from payload."
    assert said[1].startswith("This is no error: more is missing")
    assert len(said) == 3
    assert said[2].endswith("--tell armature,payload")
    assert members(both) == ["armature", "payload"]
    assert as_json(both)[0]["not_told_from"] == [{"effects": ["payload"], "collinearity": 20.0}]
