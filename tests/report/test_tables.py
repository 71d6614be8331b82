"""Tables are sorted by a click, on the page and on the scoreboard, which filters too."""

import json

from t2l.report import write_report
from t2l.report.scoreboard import breakable, render
from t2l.study.scoreboard.table import scoreboard
from tests.report.browser import browse, data_of
from tests.report.findings import compared
from tests.study.planted import cloning, evidence

CLICK = """<script>
const tables = [...document.querySelectorAll("table.sortable")];
const table = tables.find(one => one.textContent.includes("kp80"));
const headers = [...table.tHead.rows[0].cells];
const header = name => headers.find(cell => cell.textContent.startsWith(name));
const order = () => [...table.tBodies[0].rows].map(row => row.cells[0].textContent);
const orders = [order()];
for (const name of ["Kp", "Kp", "recording"]) { header(name).click(); orders.push(order()); }
header("duration").dispatchEvent(new KeyboardEvent("keydown", { key: "Enter" }));
orders.push(header("duration").getAttribute("aria-sort"), header("Kp").getAttribute("aria-sort"));
document.body.dataset.orders = JSON.stringify(orders);
</script></body>"""


def test_a_click_on_a_header_sorts_by_value(tmp_path):
    dom = browse(write_report(compared(tmp_path)), tmp_path, CLICK)
    first, down, up, by_name, duration, kp = json.loads(data_of(dom, "orders"))
    assert sorted(first) == sorted(down)
    # by number, not by letters: 80 comes before 5
    assert down == ["kp80", "kp20", "kp5"]
    assert up == ["kp5", "kp20", "kp80"]
    assert by_name == ["kp5", "kp20", "kp80"]
    assert (duration, kp) == ("descending", "none")


FILTER = """<script>
const seen = () => [...document.querySelectorAll("tbody tr:not(.group):not([hidden])")];
const groups = () => [...document.querySelectorAll("tr.group")].filter(row => !row.hidden).length;
const told = { all: seen().length, groups: groups(), order: seen().map(row => row.id) };
const words = document.getElementById("words");
const say = text => { words.value = text; words.dispatchEvent(new Event("input")); };
say("DISHRACK unloading");
told.words = seen().length;
told.found = seen().every(row => row.textContent.toLowerCase().includes("dishrack"));
told.groupsOfWords = groups();
say("");
for (const box of document.querySelectorAll("input.verdict"))
  if (box.value !== "reproduced") box.click();
told.verdicts = [...new Set(seen().map(row => row.dataset.verdict))];
const p = [...document.querySelectorAll("thead th")].find(cell => cell.textContent.startsWith("p"));
p.click(); p.click();
told.p = seen().map(row => row.querySelector("td.p").dataset.value).filter(Boolean).map(Number);
told.chain = getComputedStyle(document.querySelector(".of")).display;
const cells = [...document.querySelectorAll("td, th")];
told.width = cells.filter(cell => cell.scrollWidth > cell.clientWidth + 1).length;
const style = getComputedStyle(document.querySelector("td"));
told.breaks = [style.overflowWrap, style.wordBreak];
document.getElementById("reset").click();
told.again = seen().map(row => row.id);
document.body.dataset.told = JSON.stringify(told);
</script></body>"""


def test_the_scoreboard_sorts_filters_and_breaks_no_word(tmp_path):
    table = scoreboard(evidence(block_stack__nominal__cells=cloning(CO=0.8)))
    page = tmp_path / "scoreboard.html"
    page.write_text(render(table, ["planted"], "fr3"))
    told = json.loads(data_of(browse(page, tmp_path, FILTER), "told"))
    assert told["all"] == len(table)
    assert told["groups"] == table.chain.nunique()
    assert told["found"]
    assert 0 < told["words"] < len(table)
    assert 0 < told["groupsOfWords"] < told["groups"]
    assert told["verdicts"] == ["reproduced"]
    assert len(told["p"]) > 1
    assert told["p"] == sorted(told["p"])
    assert told["chain"] == "inline"
    assert told["breaks"] == ["normal", "normal"]
    assert told["width"] == 0
    assert told["again"] == told["order"] == list(table.id)


def test_long_names_may_be_broken_where_they_are_put_together():
    assert breakable("no table of dishrack_unloading here") == "no table of dishrack_unloading here"
    assert breakable("results/a_study_of_gains/tables") == (
        "results/<wbr>a_<wbr>study_<wbr>of_<wbr>gains/<wbr>tables"
    )
    assert breakable("p 6.9e-231, <b>") == 'p <span class="whole">6.9e-231,</span> &lt;b&gt;'
