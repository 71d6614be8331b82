import numpy as np
import pytest
from matplotlib.image import imread

from t2l.diagnose.fronts import fronts
from t2l.diagnose.results import read_found
from t2l.figures import diagnosis as figures
from tests.report.findings import compared, diagnosed, diagnosis, explained

OF_COMPARISON = {"overlays", "error_by_cell", "residual_by_condition", "spectrum"}


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return read_found(compared(tmp_path_factory.mktemp("one"))).compared


@pytest.mark.parametrize(
    ("make", "draw", "names"),
    [
        (compared, figures.draw_comparison, OF_COMPARISON),
        (diagnosed, figures.draw_diagnosis, {"ranking"}),
        (
            explained,
            figures.draw_explanation,
            OF_COMPARISON | {"error_falling", "front_1", "front_2"},
        ),
    ],
    ids=["compare", "diagnose", "explain"],
)
def test_every_figure_is_written_with_something_in_it(tmp_path, make, draw, names):
    draw(make(tmp_path))
    written = {path.name for path in (tmp_path / "figures").iterdir()}
    assert written == {f"{name}.{suffix}" for name in names for suffix in ("png", "pdf")}
    for name in names:
        assert (tmp_path / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")
        assert imread(tmp_path / "figures" / f"{name}.png")[..., :3].std() > 0.03


def test_overlays_show_the_worst_first(one):
    figure = figures.overlays(one)
    titles = [panel.get_title() for panel in figure.axes]
    assert titles == ["worst: kp5", "median: kp20", "best: kp80"]
    measured = {line.get_label(): line for line in figure.axes[0].lines}["measured"]
    traces = one[0].traces
    np.testing.assert_array_equal(measured.get_ydata(), traces.columns["q"][traces.at(0, 0)])


def test_cells_have_kd_upward_and_kp_to_the_right(one):
    panel = figures.error_by_cell(one).axes[0]
    values = panel.images[0].get_array()
    assert panel.images[0].origin == "lower"
    logs = one[0].numbers["logs"]
    for i, log in enumerate(logs):
        assert values[i, i] == pytest.approx(1e3 * log["rmse_q_rad"])
    assert values.mask.sum() == 6
    assert [t.get_text() for t in panel.get_xticklabels()] == ["5", "20", "80"]


def test_colours_of_errors_begin_at_the_noise(one):
    norm = figures.error_by_cell(one).axes[0].images[0].norm
    floor = 1e3 * one[0].numbers["noise_floor_rad"]
    assert norm.vmin == pytest.approx(floor)
    assert norm.vmax >= 10 * floor


def test_axes_say_which_torque_they_show(one):
    labels = [panel.get_xlabel() for panel in figures.residual_by_condition(one).axes]
    assert "commanded torque [N·m]" in labels
    assert "torque [N·m]" not in labels


def test_friction_shows_as_a_step_in_the_velocity(one):
    line = figures.residual_by_condition(one).axes[0].lines[0]
    velocity, torque = line.get_data()
    assert np.median(torque[velocity < -0.3]) == pytest.approx(0.06, abs=0.015)
    assert np.median(torque[velocity > 0.3]) == pytest.approx(-0.06, abs=0.015)


def test_the_error_falls_to_the_floor():
    steps = [("model as it came", 0.02, 0.01), ("+ armature", 2e-4, 2e-4), ("+ curves", None, 1e-4)]
    axes = figures.error_falling(steps, 5e-5).axes[0]
    np.testing.assert_allclose(axes.lines[0].get_ydata(), [10, 0.2, 0.1])
    np.testing.assert_allclose(axes.lines[1].get_ydata(), [20, 0.2])
    np.testing.assert_allclose(axes.lines[2].get_ydata(), 0.05)
    assert axes.get_yscale() == "log"


def test_a_front_marks_what_was_adopted_and_joins_what_was_simulated(tmp_path):
    first, last = fronts(read_found(explained(tmp_path)))
    axes = figures.front(first, 5e-5).axes[0]
    lines = {line.get_label(): line for line in axes.lines}
    np.testing.assert_allclose(lines["adopted"].get_xydata(), [[1, 0.07]])
    assert len(lines["linear model only"].get_xdata()) == 5
    assert len(lines["simulated"].get_xdata()) == 3
    (joined,) = (line for line in axes.lines if line.get_drawstyle() == "steps-post")
    np.testing.assert_allclose(joined.get_xydata(), [[1, 0.07], [2, 0.069]])
    labels = {line.get_label() for line in figures.front(last, 5e-5).axes[0].lines}
    assert not any(label.startswith("adopted") for label in labels)


def test_the_ranking_has_the_best_above_and_keeps_the_hopeless_at_the_edge():
    axes = figures.ranking(diagnosis()).axes[0]
    assert axes.get_yticklabels()[0].get_text() == "Coulomb friction"
    assert axes.yaxis_inverted()
    interval, point = axes.lines[0], axes.lines[1]
    np.testing.assert_allclose(interval.get_xdata(), [97, 101])
    np.testing.assert_allclose(point.get_xdata(), [99])
    linear, hopeless = axes.lines[5], axes.lines[7]
    assert linear.get_markerfacecolor() == "white"
    assert hopeless.get_marker() == "<"
    np.testing.assert_allclose(hopeless.get_xdata(), [-40])
