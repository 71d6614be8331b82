"""Names and notes come from files that somebody sent: the page shows them and runs nothing."""

import json
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet

from t2l.report import write_report
from t2l.report.scoreboard import render
from t2l.study.scoreboard.table import scoreboard
from tests.report.browser import browse, data_of
from tests.report.findings import explained_with_proposal
from tests.study.planted import evidence

RUN = "</script><img src=x onerror=\"document.body.dataset.ran='yes'\"><b>\"'&amp;%{x}"
HOSTILE = {"hinge": f"hinge{RUN}", "kp5": f"kp5{RUN}", "Coulomb friction": f"friction{RUN}"}

SHOWN = """<script>
setTimeout(() => {
  for (const menu of document.querySelectorAll("select")) {
    menu.value = menu.options[menu.options.length - 1].value;
    menu.dispatchEvent(new Event("change"));
  }
  for (const header of document.querySelectorAll("th")) header.click();
  const shown = part => [...document.querySelectorAll(part)].map(e => e.textContent).join(" ");
  const whole = text => text.replace(/\\s/g, "");
  document.body.dataset.shown = JSON.stringify({
    images: document.querySelectorAll("img").length,
    menu: shown("select").includes(HOSTILE[0]) && shown("select").includes(HOSTILE[1]),
    story: shown("main").includes(HOSTILE[0]),
    steps: shown("h3").includes(HOSTILE[2]),
    // Plotly shows what is in an SVG, and breaks lines at spaces
    plots: whole(shown("[data-plot=falling] .xtick")).includes(whole(HOSTILE[2])),
  });
}, 4000);
</script></body>"""


def changed(content):
    """Every text of JSON with hostile names, keys too."""
    if isinstance(content, dict):
        return {changed(key): changed(value) for key, value in content.items()}
    if isinstance(content, list):
        return [changed(value) for value in content]
    if isinstance(content, str):
        for name, hostile in HOSTILE.items():
            content = content.replace(name, hostile)
    return content


def hostile(folder: Path) -> Path:
    """An explanation of recordings, joints and effects with such names."""
    explained_with_proposal(folder)
    before = json.loads((folder / "before" / "comparison.json").read_text())
    robot = folder / "robot.xml"
    mjcf = Path(before["robot_file"]).read_text()
    robot.write_text(mjcf.replace('name="hinge"', f"name={quoteattr(HOSTILE['hinge'])}"))
    for path in folder.rglob("*.json"):
        content = changed(json.loads(path.read_text()))
        if path.name == "comparison.json":
            content["robot_file"] = str(robot)
        path.write_text(json.dumps(content))
    for path in folder.rglob("traces.parquet"):
        table = pa.parquet.read_table(path)
        for name in ("recording", "joint"):
            column = table[name].combine_chunks()
            labels = pa.array(changed(column.dictionary.to_pylist()))
            at = table.column_names.index(name)
            table = table.set_column(
                at, name, pa.DictionaryArray.from_arrays(column.indices, labels)
            )
        pa.parquet.write_table(table, path)
    model = folder / "model.yaml"
    model.write_text(f"# {RUN}\n{model.read_text()}")
    return folder


def test_nothing_that_a_name_says_is_run(tmp_path):
    page = write_report(hostile(tmp_path))
    texts = json.dumps([*HOSTILE.values()]).replace("<", "\\u003c")
    script = SHOWN.replace("<script>", f"<script>const HOSTILE = {texts};")
    dom = browse(page, tmp_path, script, webgl=True)
    assert data_of(dom, "ran") is None
    assert data_of(dom, "errors") == "0"
    assert data_of(dom, "plots") == data_of(dom, "plots-drawn")
    shown = json.loads(data_of(dom, "shown"))
    assert shown == {"images": 0, "menu": True, "story": True, "steps": True, "plots": True}


def test_nothing_that_a_scoreboard_says_is_run(tmp_path):
    table = scoreboard(evidence())
    table.loc[0, ["ours", "theirs", "note", "rule", "results"]] = RUN
    page = tmp_path / "page.html"
    page.write_text(render(table, [RUN], RUN))
    dom = browse(page, tmp_path, "</body>")
    assert data_of(dom, "ran") is None
    assert "<img" not in dom
