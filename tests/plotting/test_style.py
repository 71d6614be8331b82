import json
import warnings
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text

from t2l.diagnose.results import Compared, read_found
from t2l.figures import diagnosis as figures
from t2l.gains import Grid
from t2l.plotting import heatmap, style
from t2l.report import write_report
from tests.report.findings import compared, diagnosis

NAMES = {
    "formula": r"$\frac{$",
    "two dollars": r"a$\frac{$b",
    "long": "x" * 300,
    "words": "name " * 60,
    "newlines": "a\nb\r\tc\x1b[31m",
    "surrogate": "a\udcff",
    "percent": "100 % {x} \\",
}


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return read_found(compared(tmp_path_factory.mktemp("one"))).compared[0]


def _renamed(one, name):
    traces = one.traces
    numbers = dict(one.numbers)
    numbers["cells"] = [c | {"joint": c["joint"] and name} for c in numbers["cells"]]
    renamed = type(traces)(
        tuple(name for _ in traces.recordings), (name,), traces.recording, traces.joint,
        traces.columns,
    )  # fmt: skip
    return Compared("model", numbers, renamed)


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
@pytest.mark.parametrize("draw", ["overlays", "error_by_cell", "residual_by_condition", "spectrum"])
def test_every_name_can_be_drawn(one, tmp_path, name, draw):
    plain = getattr(figures, draw)([one])
    size = plain.get_size_inches().copy()
    plt.close(plain)
    figure = getattr(figures, draw)([_renamed(one, name)])
    np.testing.assert_array_equal(figure.get_size_inches(), size)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        style.write(figure, [tmp_path / "a.png", tmp_path / "a.pdf"])
    assert imread(tmp_path / "a.png")[..., :3].std() > 0.03


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_every_name_of_an_effect_can_be_drawn(tmp_path, name):
    content = diagnosis()
    content["ranking"][0]["title"] = name
    steps = [("model as it came", 0.02, 0.01), (f"+ {name}", 2e-4, 1e-4)]
    drawn = [figures.ranking(content), figures.error_falling(steps, 5e-5)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for figure in drawn:
            style.write(figure, [tmp_path / "a.png"])


def test_names_are_shown_as_they_are_in_one_line():
    assert style.shown(r"$\frac{$") == r"$\frac{$"
    assert style.shown("a\nb\x00") == "a\ufffdb\ufffd"
    long = style.shown("a" * 100 + "z" * 100)
    assert len(long) == style.MOST_CHARACTERS
    assert long[0] == "a"
    assert long[-1] == "z"


def test_powers_of_ten_are_read_without_formulas(tmp_path):
    with style.styled():
        figure, axes = plt.subplots()
        axes.semilogy([1, 2], [1e-7, 1e3])
        axes.set_title("$")
    style.write(figure, [tmp_path / "a.png"])
    texts = [label.get_text() for label in axes.get_yticklabels()]
    assert "10⁻⁵" in texts
    assert not any("$" in text or "\\" in text for text in texts)
    with style.styled():
        figure, axes = plt.subplots()
        axes.semilogy([1, 2], [1.5e-3, 8e-3])
    style.write(figure, [tmp_path / "a.png"])
    texts = [label.get_text() for label in axes.get_yticklabels(which="both")]
    assert "2×10⁻³" in texts


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_a_page_holds_every_name(tmp_path, name):
    folder = compared(tmp_path)
    path = folder / "comparison.json"
    numbers = json.loads(path.read_text())
    numbers["logs"][0]["name"] = numbers["robot"] = name.replace("\udcff", "")
    path.write_text(json.dumps(numbers))
    write_report(folder)


def test_the_region_is_the_only_formula(tmp_path):
    with style.styled():
        figure, axes = plt.subplots()
        grid = Grid((16, 512), (2, 24), compliant_up_to_kp=16, overdamped_from_kd=24)
        heatmap.heatmap(
            axes, np.ones((2, 2)), grid, "viridis", plt.Normalize(0, 1), str, None, region="CO"
        )
    (region,) = (text for text in axes.findobj(Text) if text.get_text().endswith("$G^{CO}$"))
    assert region.get_parse_math()
    assert not axes.xaxis.label.get_parse_math()
    plt.close(figure)


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        (["fr3_joint1", "fr3_joint2"], ["joint1", "joint2"]),
        (["elbow_joint", "wrist_1_joint"], ["elbow", "wrist_1"]),
        (["q_des.fr3_joint1", "q_des.fr3_joint2"], ["joint1", "joint2"]),
        (["q.left/a1", "q.left/a2", "q.right/a1"], ["left/a1", "left/a2", "right/a1"]),
        (["hinge"], ["hinge"]),
        (["x_y", "x_q_y"], ["x_y", "q"]),
    ],
)
def test_labels_leave_out_what_all_names_share(names, labels):
    assert list(style.short(names).values()) == labels


@pytest.mark.parametrize("low", [2e-4, 0.07, 40.0])
@pytest.mark.parametrize("factor", [1.3, 2.0, 5.0, 9.0, 25.0, 60.0, 1e3, 1e5])
def test_plain_labels_of_a_logarithmic_axis_do_not_touch(low, factor):
    with style.styled():
        figure, axes = plt.subplots(figsize=(2.6, 2.6))
        axes.loglog([low, low * factor], [low, low * factor])
        style.plain_ticks(axes.xaxis, axes.yaxis)
        figure.canvas.draw()
    inside = axes.get_window_extent()
    for axis, ends in ((axes.xaxis, ("x0", "x1")), (axes.yaxis, ("y0", "y1"))):
        boxes = [label.get_window_extent() for label in axis.get_ticklabels(which="both")
                 if label.get_text()]  # fmt: skip
        spans = sorted([getattr(box, end) for end in ends] for box in boxes)
        assert all(a[1] < b[0] for a, b in pairwise(spans))
        middles = [sum(span) / 2 for span in spans]
        low_end, high_end = (getattr(inside, end) for end in ends)
        assert sum(low_end <= middle <= high_end for middle in middles) >= 2
    plt.close(figure)
