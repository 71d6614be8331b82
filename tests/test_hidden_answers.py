"""How an explanation of a case is judged: names, and curves where an effect has no name."""

import pytest
from benchmarks import hidden

# an unknown effect on the elbow, beside a known one
RESULT = {
    "hidden": ["odd_position_torque", "armature"],
    "unknown": ["odd_position_torque"],
    "unknown_on": ["elbow"],
    "hardly_seen": [],
    "stand": ["armature"],
    "curves": ["learned_torque_elbow_position"],
    "curves_on": [["elbow"]],
    "before": 1e-3,
    "after": 1.5e-4,
    "noise_floor": 1e-4,
    "seconds": 3.0,
    "first_answer_s": 1.0,
    "stopped": False,
}
NONE = {"curves": [], "curves_on": []}
CLEAN = RESULT | NONE | {"hidden": [], "unknown": [], "unknown_on": [], "stand": []}
PAIR = RESULT | NONE | {"hidden": ["armature", "cogging"], "unknown": [], "unknown_on": []}
HARDLY = PAIR | {"hardly_seen": ["cogging"]}


@pytest.mark.parametrize(
    ("result", "right"),
    [
        (RESULT, True),
        (RESULT | {"curves_on": [["shoulder"]]}, False),
        (RESULT | {"curves_on": [["elbow", "shoulder"]]}, False),
        (RESULT | NONE, False),
        (RESULT | {"stand": []}, False),
        (RESULT | {"stand": ["armature", "cogging"]}, False),
        (CLEAN, True),
        (CLEAN | {"curves": ["learned_torque_elbow_position"]}, False),
        (PAIR, False),
        (PAIR | {"stand": ["cogging", "armature"]}, True),
    ],
)
def test_names_and_curves_are_judged(result, right):
    assert hidden.right(result) is right


def test_the_summary_counts_each_answer_with_its_n():
    wrong = RESULT | NONE | {"stand": ["cogging"], "after": 2e-3, "seconds": 9.0}
    table = hidden.summary([RESULT, wrong, CLEAN, PAIR, HARDLY]).set_index("what")
    assert {what: (row["found"], row["n"]) for what, row in table.iterrows()} == {
        "known effects named": ("2", 4),
        "… of those that show": ("2", 3),
        "two at once: named": ("0", 2),
        "two at once: named, as far as they show": ("1", 2),
        "two at once: named, and nothing else": ("0", 2),
        "known effects: error at most 1.2 times the noise": ("0", 2),
        "nothing hidden, yet something adopted": ("0", 1),
        "unknown effect: a wrong name beside": ("1", 2),
        "unknown effect: curves, all on its joints": ("1", 2),
        "unknown effect: error at most twice the noise": ("1", 2),
        "known effect beside an unknown one: it is named": ("1", 2),
        "… a wrong name is adopted too": ("1", 2),
        "test error larger by more than 2 %": ("1", 5),
        "stopped": ("0", 5),
        "seconds, median and longest": ("3 and 9", 5),
        "… to the first answer, median": ("1", 5),
    }


def test_joints_are_those_with_numbers_or_all():
    joints = ("shoulder", "elbow")
    some = {"effect": "Cogging", "amplitude": {"elbow": 0.1, "shoulder": 0.0}, "periods": 9.0}
    assert hidden.joints_of([some], joints) == ["elbow"]
    assert hidden.joints_of([{"effect": "BaseTilt", "pitch": 0.1}], joints) == list(joints)
