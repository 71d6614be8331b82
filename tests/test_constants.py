"""Every number that a diagnosis depends on says what kind it is, and why it has its value."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks import constants, sensitivity
from benchmarks.constants import SOURCE, census

from tests.conftest import ROOT


@pytest.fixture(scope="module")
def found():
    return census()


@pytest.mark.parametrize("package", constants.PACKAGES)
def test_every_number_has_its_kind(found, package):
    here = [c for c in found if c.place.startswith(package)]
    assert here, "no constants were found: the test looks in the wrong place"
    assert [f"{c.place}: {c.value}" for c in here if c.kind is None] == []


def test_every_constant_has_its_reason(found):
    without = [c for c in found if c.named and len(c.reason) < 3]
    # ranges of parameters say it in their own words
    assert [c.name for c in without if "Parameter(" not in c.value] == []


def test_tuned_constants_can_be_changed(found):
    assert all(c.named for c in found if c.kind == "tuned")


def written(folder: Path, text: str, package: str = "diagnose"):
    path = folder / package / "module.py"
    path.parent.mkdir(parents=True)
    path.write_text(text)
    return census(folder, [package])


def test_kinds_and_reasons_are_read(tmp_path):
    text = (
        "LEVEL = 0.05\n"
        "MOST = 3  # tuned: as many as fit\n"
        "# bound: what a gearbox\n# has\nLOW, HIGH = 1, 9\n"
        "NAME = 'x'\n"
        "ALSO = MOST\n"
    )
    found = written(tmp_path, text)
    assert [(c.name, c.kind, c.reason) for c in found] == [
        ("LEVEL", None, ""),
        ("MOST", "tuned", "as many as fit"),
        ("LOW, HIGH", "bound", "what a gearbox has"),
    ]
    assert [c.place for c in found[:2]] == ["diagnose/module.py:1", "diagnose/module.py:2"]


def test_numbers_inside_functions_count(tmp_path):
    text = (
        "def rank(x, few=7):\n"
        "    if x > 0.9 * few:  # numerics: rounding\n"
        "        return 2 * x + 1e-12\n"
        "    return f'{100 * x:.0f}'\n"
    )
    found = written(tmp_path, text)
    assert [(c.name, c.value, c.kind) for c in found] == [
        ("rank", "def rank(x, few=7):", None),
        ("rank", "if x > 0.9 * few:", "numerics"),
    ]


def test_an_effect_states_ranges_and_first_guesses_by_place(tmp_path):
    text = (
        "class Play:\n"
        "    parameters = (Parameter('play', 1e-4, 0.7),)\n"
        "    order = 30\n"
        "    def starts(self, scales):\n"
        "        return [0.01, 0.03]\n"
        "    def install(self, loop):\n"
        "        return 0.9\n"
    )
    kinds = [c.kind for c in written(tmp_path, text, "effects")]
    assert kinds == ["bound", "format", "guess", None]


@pytest.mark.parametrize(
    ("source", "factor", "value"),
    [("0.05", 2.0, "0.1"), ("(2, 3)", 0.5, "(1, 1)"), ("1", 0.5, "1"), ("-0.5", 2.0, "-1.0")],
)
def test_numbers_are_changed(source, factor, value):
    assert sensitivity.changed(source, factor) == value


def test_only_what_changes_is_done(found):
    jobs = list(sensitivity.jobs([("t2l.a", "ONE", "1"), ("t2l.a", "TWO", "2")], ["clean"]))
    assert jobs == [
        ("", "", 1.0, "clean"),
        ("t2l.a", "ONE", 2.0, "clean"),
        ("t2l.a", "TWO", 0.5, "clean"),
        ("t2l.a", "TWO", 2.0, "clean"),
    ]


def test_every_tuned_constant_can_be_halved_or_doubled(found):
    tuned = [(constants.module_of(c), c.name, c.value) for c in found if c.kind == "tuned"]
    changed = {name for _, name, _, _ in sensitivity.jobs(tuned, ["clean"])} - {""}
    assert changed == {name for _, name, _ in tuned}


def test_what_is_made_of_a_constant_changes_with_it():
    code = (
        "import sys; from benchmarks.sensitivity import Changed\n"
        "sys.meta_path.insert(0, Changed('t2l.identify.levels', 'AT_THE_FLOOR', 2.0))\n"
        "from t2l.diagnose.ranking import AT_THE_FLOOR, NEAR_THE_FLOOR\n"
        "print(AT_THE_FLOOR, NEAR_THE_FLOOR)"
    )
    told = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert told.stdout.split() == ["2.2", str(2.2**2)], told.stderr


def test_results_are_compared_with_those_without_a_change(tmp_path):
    as_is = {
        "verdict": "x",
        "first": "payload",
        "adopted": ["payload"],
        "final_verdict": "x",
        "curves": [],
    }
    as_is |= {"after": 2e-4, "seconds": 10.0}
    wrong = as_is | {"first": "armature", "after": 3e-4, "seconds": 20.0}
    levels = [("t2l.a", "LEVEL", "0.5")]
    jobs = sensitivity.jobs(levels, ["clean"])
    for job, result in zip(jobs, (as_is, as_is, wrong), strict=True):
        path = sensitivity._file(tmp_path, *job)
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps(result))
    rows = sensitivity.rows(levels, tmp_path, ["clean"])
    assert rows["same answer"].tolist() == [True, True, False]
    (row,) = sensitivity.told(rows).to_dict("records")
    assert row["constant"] == "a.LEVEL"
    assert row["halved: answers changed"] == "0 of 1"
    assert row["doubled: answers changed"] == "1 of 1"
    assert row["doubled: error"] == "1.50 to 1.50"


def test_the_source_is_that_of_the_package():
    assert (SOURCE / "diagnose" / "settings.py").exists()
