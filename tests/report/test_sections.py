"""What a reader finds on the page: sections, parameters, legends, tool bars, files to save."""

import base64
import csv
import io
import json
import re

import pytest

from t2l.diagnose.compare import compare, write
from t2l.diagnose.results import read_found
from t2l.figures.diagnosis.gains import error_by_cell
from t2l.identify.model import Model
from t2l.report import write_report
from t2l.report.payload import payload
from tests.diagnose.made import pendulum, swings
from tests.report.browser import browse, data_of
from tests.report.findings import (
    FRICTION,
    compared,
    diagnosed,
    explained,
    explained_with_proposal,
    proposed,
)

STORIES = [compared, diagnosed, proposed, explained_with_proposal]

# saves all that can be saved; how a legend differs from its marks; what tool bars offer
READ = """<script>
const files = [], problems = [], tools = [];
addEventListener("load", () => setTimeout(() => {
  // text that becomes a file; reading a blob takes time that is not the page's
  let text;
  window.Blob = function (parts) { text = parts.join(""); };
  URL.createObjectURL = () => "blob:none";
  HTMLAnchorElement.prototype.click = function () { files.push([this.download, text]); };
  for (const button of document.querySelectorAll("button.download, button.csv")) button.click();
  const look = ({ line, marker }) => `${line?.color} ${line?.dash} ${marker?.symbol}`;
  const color = t => t.line?.color || t.marker?.color;
  for (const plot of document.querySelectorAll("[data-plot]")) {
    const buttons = plot.querySelectorAll(".modebar:not(.modebar--hover) [data-title]");
    tools.push([...buttons].map(button => button.dataset.title));
    const drawn = plot.data.filter(t => t.type !== "heatmap" && t.line?.width !== 0 || t.fill);
    const inLegend = drawn.filter(t => t.showlegend !== false);
    const texts = [...plot.querySelectorAll(".legendtext")].map(t => t.textContent);
    const problem = what => problems.push([plot.dataset.plot, what]);
    if (drawn.length > 1 && texts.length !== inLegend.length) problem(texts);
    for (const trace of drawn) {
      const { symbol, color: colors } = trace.marker ?? {};
      if (Array.isArray(symbol) || Array.isArray(colors)) problem("several marks");
      const own = inLegend.find(t => t.name === trace.name);
      if (!own || color(own) !== color(trace)) problem(trace.name);
      else if (own.line && look(own) !== look(trace)) problem(trace.name);
    }
  }
  const all = JSON.stringify({ files, problems, tools });
  document.body.dataset.read = btoa(unescape(encodeURIComponent(all)));
}, 3000));
</script></body>"""


@pytest.fixture(scope="module", params=STORIES, ids=lambda make: make.__name__)
def page(request, tmp_path_factory):
    return write_report(request.param(tmp_path_factory.mktemp(request.param.__name__)))


@pytest.fixture(scope="module")
def read(page, tmp_path_factory):
    """What a browser makes of the page."""
    dom = browse(page, tmp_path_factory.mktemp("browser"), READ)
    assert data_of(dom, "errors") == "0"
    return json.loads(base64.b64decode(data_of(dom, "read")))


def test_every_section_has_a_place_that_the_contents_lead_to(page):
    text = re.sub(r"<script.*?</script>", "", page.read_text(), flags=re.DOTALL)
    headings = re.findall(r"<h2([^>]*)>(.*?)</h2>", text)
    places = re.findall(r'<h2 id="([a-z][a-z0-9-]*)">', text)
    assert len(places) == len(headings) == len(set(places))
    contents = re.search(r"<nav.*?</nav>", text, re.DOTALL)[0]
    assert re.findall(r'href="#([^"]+)"', contents) == places
    assert set(re.findall(r'href="#([^"]+)"', text)) == set(places)
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids))


def test_legends_match_the_marks(read):
    assert read["problems"] == []


def test_every_plot_has_a_tool_bar(read):
    assert read["tools"]
    for tools in read["tools"]:
        assert {"Zoom", "Pan", "Download plot as a PNG", "Reset axes"} <= set(tools)


def test_what_is_saved_is_what_was_found(page, read):
    saved = dict(read["files"])
    offered = re.findall(r'data-file="([^"]+)"', page.read_text())
    assert offered
    for name in offered:
        where = page.parent / ("proposal" if name == "proposal.json" else "") / name
        where = where if where.exists() else page.parent / name
        if name.endswith(".json"):
            assert json.loads(saved[name]) == json.loads(where.read_text())
        else:
            assert saved[name] == where.read_text()


def test_the_numbers_of_every_plot_are_saved_as_a_table(page, read):
    tables = {name: text for name, text in read["files"] if name.endswith(".csv")}
    assert tables
    assert len(tables) == page.read_text().count('class="csv"')
    for name, text in tables.items():
        header, *rows = csv.reader(io.StringIO(text))
        assert rows, name
        assert {len(row) for row in rows} == {len(header)}
    if "overlay.csv" in tables:
        header, *rows = csv.reader(io.StringIO(tables["overlay.csv"]))
        assert header[:3] == ["time [s]", "commanded [rad]", "measured [rad]"]
        measured, simulated, error = (float(rows[5][i]) for i in (2, 3, 4))
        assert error == pytest.approx(1e3 * (measured - simulated), abs=1e-3)
    if "ranking.csv" in tables:
        # no value is cut off, unlike in the plot
        assert "armature,-300,-302,-298,other" in tables["ranking.csv"]
    if "front0.csv" in tables:
        first = next(csv.DictReader(io.StringIO(tables["front0.csv"])))
        assert (first["set"], first["judged by"], first["adopted"]) == (
            "Coulomb friction", "simulation", "yes",
        )  # fmt: skip


def test_the_final_parameters_have_their_intervals(tmp_path):
    folder = explained(tmp_path)
    path = folder / "explanation.json"
    content = json.loads(path.read_text())
    content["parameters"].append(
        content["parameters"][0]
        | {"title": "command delay", "joint": None, "parameter": "delay", "ci95": None}
    )
    path.write_text(json.dumps(content))
    text = write_report(folder).read_text()
    table = text[text.index('id="parameters"') :]
    table = table[: table.index("</table>")]
    rows = re.findall(r"<tr><td>(.*?)</tr>", table, re.DOTALL)
    cells = [re.sub(r"(<[^>]*>|\s)+", "|", row) for row in rows]
    expected = "Coulomb|friction|hinge|torque|0.0601|0.0595|to|0.0607|N·m|friction|torque"
    assert cells[0].replace("|", " ").split() == expected.split("|")
    untold = "command|delay|all|delay|0.0601|not|determined"
    assert cells[1].replace("|", " ").split()[:7] == untold.split("|")
    # one that an earlier version wrote
    del content["parameters"]
    path.write_text(json.dumps(content))
    assert 'id="parameters"' not in write_report(folder).read_text()


def test_one_pair_of_gains_is_no_map(tmp_path):
    robot = pendulum(tmp_path)
    write(compare(Model(robot), swings(robot, FRICTION, 5e-5)[:1]), tmp_path)
    text = write_report(tmp_path).read_text()
    assert 'data-plot="cells"' not in text
    assert "one pair of gains in all recordings" in text
    found = read_found(tmp_path)
    assert payload(found)["cell_limits"] == {}
    # of two joints with gains of their own, each has one pair
    content = json.loads((tmp_path / "comparison.json").read_text())
    content["cells"] += [content["cells"][0] | {"joint": None, "kp": 50.0}]
    content["logs"][0]["kp"] = [5.0, 50.0]
    (tmp_path / "comparison.json").write_text(json.dumps(content))
    found = read_found(tmp_path)
    assert payload(found)["cell_limits"] == {}
    figure = error_by_cell(found.compared)
    assert figure.axes[0].containers
    assert [len(axes.images) for axes in figure.axes] == [0]
    assert 'data-plot="cells"' in write_report(compared(tmp_path / "three")).read_text()


def test_the_colours_of_a_map_begin_at_the_noise(tmp_path):
    found = read_found(compared(tmp_path))
    floor = 1e3 * found.compared[0].numbers["noise_floor_rad"]
    for low, high in payload(found)["cell_limits"].values():
        assert low == pytest.approx(floor)
        assert high >= 10 * floor


def test_torques_say_whether_they_are_commanded_or_delivered(tmp_path):
    found = read_found(explained_with_proposal(tmp_path))
    content = payload(found)
    labels = {one["name"]: one["label"] for one in content["conditions"]}
    for name in ("torque", "torque rate", "load"):
        assert "commanded torque" in labels[name]
    assert content["curves"][0]["torque_title"] == "delivered torque [N·m]"
    text = re.sub(r"<script.*?</script>", "", write_report(tmp_path).read_text(), flags=re.DOTALL)
    assert ">torque</option>" not in text
    assert "commanded torques at" in text


def test_bars_and_rows_are_ordered_by_their_value(tmp_path):
    ranking = payload(read_found(diagnosed(tmp_path)))["ranking"]
    improvements = [entry["improvement"] for entry in ranking]
    assert improvements == sorted(improvements, reverse=True)
    folder = explained(tmp_path)
    found = read_found(folder)
    text = write_report(folder).read_text()
    for shares in re.findall(r'<ul class="shares">(.*?)</ul>', text, re.DOTALL):
        widths = [int(width) for width in re.findall(r"width:(\d+)%", shares)]
        assert widths == sorted(widths, reverse=True)
    recordings = text[text.index('id="recordings"') :]
    names = re.findall(r"<tr><td>(kp\d+)</td>", recordings)
    logs = {log["name"]: log["rmse_q_rad"] for log in found.compared[0].numbers["logs"]}
    assert names == sorted(logs, key=lambda name: -logs[name])
