import json
import re

import numpy as np
import pytest

from t2l.diagnose.results import errors_by_step, read_found
from t2l.diagnose.traces import read_traces
from t2l.errors import ArtefactError
from t2l.report import write_report
from t2l.report.payload import payload, recordings_to_show
from t2l.report.words import mrad, sentence
from tests.report.browser import browse
from tests.report.findings import (
    compared,
    diagnosed,
    explained,
    explained_with_proposal,
    proposed,
)

# chooses every option of every menu in turn, and counts
TRY_ALL = """<script>
for (const menu of document.querySelectorAll("select"))
  for (const option of menu.options) {
    menu.value = option.value;
    menu.dispatchEvent(new Event("change"));
    document.body.dataset.tried = Number(document.body.dataset.tried || 0) + 1;
  }
</script></body>"""
LARGEST = 8e6  # bytes


@pytest.fixture(
    scope="module",
    params=[compared, diagnosed, proposed, explained_with_proposal],
    ids=lambda f: f.__name__,
)
def page(request, tmp_path_factory):
    folder = request.param(tmp_path_factory.mktemp(request.param.__name__))
    return write_report(folder)


def _check_order(told, texts):
    """Each text is there, one after the other."""
    places = [told.find(text) for text in texts]
    assert -1 not in places
    assert places == sorted(places)


def _told(page):
    """The page without its scripts and its contents."""
    return re.sub(r"<(script|nav).*?</\1>", "", page.read_text(), flags=re.DOTALL)


def test_a_browser_draws_every_plot_without_an_error(page, tmp_path):
    dom = browse(page, tmp_path, TRY_ALL)
    body = re.search(r"<body[^>]*>", dom)[0]
    state = dict(re.findall(r'data-([a-z-]+)="(\d+)"', body))
    expected = len(re.findall(r'data-plot="', _told(page)))
    assert expected >= 1
    options = _told(page).count("<option")
    assert int(state.pop("tried", 0)) == options
    assert state == {"plots": str(expected), "plots-drawn": str(expected), "errors": "0"}
    assert dom.count('class="main-svg"') >= expected
    if 'id="view"' in _told(page):
        assert 'data-view="none"' in body
        assert "This browser has no WebGL" in dom


def test_the_page_is_small_and_needs_no_network(page):
    text = page.read_text()
    assert len(text.encode()) < LARGEST
    assert "default-src 'none'" in text
    assert not re.search(r'(?:src|href)="(?!data:|#)', _told(page))
    assert "NaN" not in re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1]


def test_a_comparison_tells_what_where_and_how_much(tmp_path):
    folder = compared(tmp_path)
    numbers = json.loads((folder / "comparison.json").read_text())
    told = _told(write_report(folder))
    assert mrad(numbers["rmse_q_rad"]) in told
    assert mrad(numbers["noise_floor_rad"]) in told
    assert sentence(numbers["findings"][0]["sentence"]) in told
    assert "follows the direction of motion" in told
    assert "Kp 5 to 80 N·m/rad" in told
    assert "kp80" in told


def test_an_explanation_tells_the_story(tmp_path):
    told = _told(write_report(explained(tmp_path)))
    order = [
        "The model lacks Coulomb friction. More is missing.",
        "<b>0.07 mrad</b><span>test error of the final model",
        "The model and the recordings",
        "The error falls",
        "Parameters of the final model",
        "0.0595 to 0.0607",
        "What was compared",
        "Step 1: + Coulomb friction",
        "All 9 sets",
        "Last round: nothing was adopted",
        "No simulated set lowers the error of 0.07 mrad",
        "Measured and simulated motion",
        "coulomb_friction:",
    ]
    _check_order(told, order)
    assert "kp80 · " in told


def test_a_diagnosis_tells_the_first_effect_and_how_all_were_judged(tmp_path):
    told = " ".join(_told(write_report(diagnosed(tmp_path))).split())
    order = [
        "The model lacks Coulomb friction.",
        "1 recording, kp80",
        "hinge.torque",
        "The recordings cannot tell it from Stribeck friction",
        "Command a slow sine at Kp 5",
        "left out of the fit in turn, with a 95 % interval",
        "What remains",
        "41 % of the missing torque follows the position",
    ]
    _check_order(told, order)
    assert "validation" not in told
    (row,) = re.findall(r"<tr><td>viscous friction</td>.*?</tr>", told)
    assert row.count(">not simulated<") == 2
    kinds = {entry["title"]: entry["kind"] for entry in payload(read_found(tmp_path))["ranking"]}
    assert kinds == {
        "Coulomb friction": "best",
        "Stribeck friction": "tied",
        "viscous friction": "linear",
        "armature": "other",
    }


def test_sets_are_in_order_and_the_adopted_one_is_marked(tmp_path):
    told = " ".join(_told(write_report(explained(tmp_path))).split())
    first, last = payload(read_found(tmp_path))["fronts"]
    assert first["numbers"] == [1, 1, 1, 1, 2, 2, 3, 4, 6]
    assert first["names"][:2] == ["Coulomb friction", "viscous friction"]
    assert first["adopted"] == 0
    # of what was simulated: a linear model's promise is no part of the front
    assert [first["names"][i] for i in first["best"]] == [
        "Coulomb friction", "Coulomb friction and armature",
    ]  # fmt: skip
    assert (last["adopted"], last["adopted_error"]) == (None, None)
    assert last["before"] == pytest.approx(0.07)
    rows = re.findall(r'<tr class="adopted">.*?</tr>', told)
    assert len(rows) == 1
    assert "Coulomb friction</td>" in rows[0]
    assert "simulation, adopted" in rows[0]
    # a long table is folded, a short one is not
    assert told.count("<details><summary>All ") == 1


def test_what_lost_numbers_afterwards_is_a_line_and_no_point(tmp_path):
    told = " ".join(_told(write_report(explained_with_proposal(tmp_path))).split())
    first, second = payload(read_found(tmp_path))["fronts"]
    assert first["adopted"] == 0
    assert second["adopted"] is None
    assert second["adopted_error"] == pytest.approx(0.06)
    assert "What was adopted (0.06 mrad) is one of these sets without what it did not need" in told


def test_a_search_that_was_stopped_does_not_say_that_nothing_helps(tmp_path):
    path = explained(tmp_path) / "explanation.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"verdict": "missing_effect"}))
    told = _told(write_report(tmp_path))
    assert "The search was stopped before it could adopt one." in told
    assert "No simulated set lowers" not in told


def test_learned_curves_are_told_as_a_part_of_the_final_model(tmp_path):
    told = " ".join(_told(write_report(explained_with_proposal(tmp_path))).split())
    assert "The learned curve <a" in told
    assert (
        "A part of the error is explained by a curve that was learned from the recordings" in told
    )
    assert "<b>1</b><span>known effect added" in told
    assert "<b>1</b><span>learned curve added" in told
    assert "t2l adopt formula_torque_hinge_position --diagnosis proposal --out" in told
    assert "adopt learned_torque_hinge_position" not in told
    unsure = "Uncertain, as chosen in less than half of the resamples: a torque on hinge"
    assert unsure in told
    alone = " ".join(_told(write_report(proposed(tmp_path / "proposal"))).split())
    assert "To adopt it: <code>t2l adopt learned_torque_hinge_position" in alone


def test_the_error_falls_to_the_final_model_and_to_formulas(tmp_path):
    path = explained_with_proposal(tmp_path) / "proposal" / "proposal.json"
    drawn = payload(read_found(tmp_path))["falling"]
    steps = (
        "model as it came", "+ Coulomb friction", "+ a torque on hinge that follows its position",
    )  # fmt: skip
    assert drawn["names"] == steps
    content = json.loads(path.read_text())
    content["report"]["formulas_rmse_q_rad"] = 6.5e-5
    path.write_text(json.dumps(content))
    drawn = payload(read_found(tmp_path))["falling"]
    assert drawn["names"] == (*steps, "formulas for curves")
    assert drawn["test"] == pytest.approx([10, 0.07, 0.06, 0.065])
    assert drawn["train"] == pytest.approx([11, 0.06, 0.056])


def test_what_is_chosen_rarely_is_said_to_be_uncertain(tmp_path):
    explained(tmp_path)
    path = tmp_path / "explanation.json"
    content = json.loads(path.read_text())
    for share, uncertain in ((0.49, True), (0.5, False)):
        content["steps"][1]["chosen_shares"] = [share]
        path.write_text(json.dumps(content))
        page = write_report(tmp_path).read_text()
        sentence = "Uncertain, as chosen in less than half of the resamples: Coulomb friction."
        assert (sentence in page) == uncertain


def test_effects_of_one_step_are_told_by_their_titles(tmp_path):
    explained(tmp_path)
    path = tmp_path / "explanation.json"
    content = json.loads(path.read_text())
    titles = ["Coulomb friction on hinge", "command delay"]
    content["steps"][1] |= {
        "effects": ["coulomb_friction", "command_delay"],
        "titles": titles,
        "chosen_shares": [0.9, 0.4],
    }
    content["sentence"] = "The model lacks two effects. Nothing more is missing."
    path.write_text(json.dumps(content))
    page = write_report(tmp_path).read_text()
    lead = re.search(r'<p class="lead">(.*?)</p>', page, re.DOTALL)[1]
    assert lead.index("The model lacks two effects") < lead.index("Nothing more is missing")
    assert "Uncertain, as chosen in less than half of the resamples: command delay." in lead
    assert re.search(r"<b>2</b><span>known effects added", page)
    for title, share in zip(titles, ("90 %", "40 %"), strict=True):
        assert re.search(rf"<td>{title}</td>\s*<td class=.n.[^>]*>{share}", page)
    assert "validation" not in _told(tmp_path / "report.html")
    assert "left out of the fit in turn" in page
    (label, *_), *_ = errors_by_step(read_found(tmp_path))[1:]
    assert label == "+ Coulomb friction on hinge and command delay"


def test_a_step_without_a_title_for_each_effect_is_refused(tmp_path):
    explained(tmp_path)
    path = tmp_path / "explanation.json"
    content = json.loads(path.read_text())
    content["steps"][1]["titles"] = []
    path.write_text(json.dumps(content))
    with pytest.raises(ArtefactError, match=r"steps\.1: lists of several lengths"):
        read_found(tmp_path)


def test_what_a_name_is_not_told_from_stands_beside_how_often_it_was_chosen(tmp_path):
    explained(tmp_path)
    path = tmp_path / "explanation.json"
    content = json.loads(path.read_text())
    assert "not told from" not in write_report(tmp_path).read_text()
    rivals = [{"effects": ["armature", "payload"], "collinearity": 12.0}]
    name = content["steps"][1]["effects"][0]
    found = [{"effect": name, "not_told_from": rivals}]
    path.write_text(json.dumps(content | {"confounded": found}))
    page = write_report(tmp_path).read_text()
    assert "<th>not told from</th>" in page
    assert "armature and payload</td>" in page


EVIL = """</script><img src=x onerror=alert(1)>&"'"""


def _strings(content):
    """Places of all texts in JSON content."""
    items = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in items:
        if isinstance(value, str):
            yield content, key
        elif isinstance(value, (dict, list)):
            yield from _strings(value)


@pytest.mark.parametrize("make", [compared, diagnosed, explained], ids=lambda f: f.__name__)
def test_no_text_of_a_result_can_break_the_page(tmp_path, make):
    folder = make(tmp_path)
    for path in folder.rglob("*.json"):
        content = json.loads(path.read_text())
        for inner, key in list(_strings(content)):
            # the page tells effects, verdicts, conditions and joints apart by their names
            if key not in ("effect", "verdict", "condition", "joint"):
                inner[key] = EVIL
        path.write_text(json.dumps(content))
    page = write_report(folder)
    assert "<img" not in page.read_text()
    assert "&lt;/script&gt;&lt;img" in _told(page)


def test_an_empty_folder_and_a_broken_file_are_named(tmp_path):
    with pytest.raises(ArtefactError, match=r"comparison\.json"):
        write_report(tmp_path)
    (tmp_path / "diagnosis.json").write_text("{")
    with pytest.raises(ArtefactError, match="what is not JSON"):
        write_report(tmp_path)


def _changed(content, keys, value):
    """JSON content with another value under a key within; without the key if it is `None`."""
    *above, last = keys
    inner = content
    for key in above:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return content


@pytest.mark.parametrize(
    ("name", "keys", "value"),
    [
        ("explanation.json", ["steps"], None),
        ("explanation.json", ["steps"], []),
        ("explanation.json", ["steps", 0, "test_rmse_q_rad"], "small"),
        ("explanation.json", ["noise_floor_rad"], [1]),
        ("diagnosis.json", ["ranking"], {}),
        ("diagnosis.json", ["ranking"], []),
        ("diagnosis.json", ["ranking", 0, "improvement", "ci95"], [1]),
        ("diagnosis.json", ["ranking", 0, "tied_with"], None),
        ("diagnosis.json", ["baseline"], 3),
        ("explanation.json", ["steps", 1, "tried", 0, "numbers"], "few"),
        ("explanation.json", ["then_tried"], None),
        ("before/comparison.json", ["logs"], []),
        ("before/comparison.json", ["logs", 0, "kp"], []),
        ("before/comparison.json", ["joints"], {}),
        ("before/comparison.json", ["cells", 0, "joint"], "elbow"),
        ("after/comparison.json", ["findings"], 1),
        ("after/comparison.json", ["rmse_q_rad"], float("nan")),
    ],
    ids=str,
)
def test_foreign_results_are_named(tmp_path, name, keys, value):
    make = diagnosed if name == "diagnosis.json" else explained
    path = make(tmp_path) / name
    path.write_text(json.dumps(_changed(json.loads(path.read_text()), keys, value)))
    with pytest.raises(ArtefactError, match=name) as caught:
        write_report(tmp_path)
    assert caught.value.path == path


def test_of_many_long_recordings_the_best_to_the_worst_are_shown(tmp_path):
    traces = read_traces(compared(tmp_path))
    many = 40
    joint = np.zeros(many * 20_000, int)
    recording = np.repeat(np.arange(many), 20_000)
    columns = {"q": recording * 1e-3, "q_sim": np.zeros(len(joint))}
    long = type(traces)(tuple(map(str, range(many))), ("hinge",), recording, joint, columns)
    shown = recordings_to_show(long)
    assert 3 <= len(shown) < many
    assert {0, many - 1} <= set(shown)
    assert recordings_to_show(traces) == [0, 1, 2]
