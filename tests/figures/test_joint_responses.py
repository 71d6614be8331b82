"""Figures of how joints answer their commands, of few and of many."""

from dataclasses import replace

import pytest

from t2l.figures.joint_responses import MOST, response_motions
from t2l.figures.response_map import CORNERS, TOGETHER, response_map
from t2l.response.joints import responses
from t2l.response.motions import Motions
from tests.response.made import rows


@pytest.fixture(scope="module")
def few():
    """Two joints of one set of motions."""
    time, command, q = rows(12.0, 0.5, noise=1e-4, duration_s=3.0)
    both = tuple(column[:, None].repeat(2, axis=1) for column in (command, q))
    return responses(Motions("kp16_kd1", ("arm_a", "arm_b"), ((time, *both),), "rad or m"))


@pytest.fixture(scope="module")
def many(few):
    """The two joints under more gains than one panel can show."""
    labels = [f"kp{kp}" for kp in range(TOGETHER)]
    return [replace(response, label=label) for label in labels for response in few]


def panels_of(figure):
    return [axes for axes in figure.axes if axes.lines]


def test_few_joints_share_a_panel_and_many_points_have_one_for_each_joint(few, many):
    (together,) = panels_of(response_map(few, 2.0))
    assert {text.get_text() for text in together.texts} == set(CORNERS)
    panels = panels_of(response_map(many, 2.0))
    assert [axes.get_title() for axes in panels] == ["a", "b"]
    assert {axes.get_xlim() for axes in panels} == {panels[0].get_xlim()}


@pytest.mark.parametrize("draw", [lambda found: response_map(found, 2.0), response_motions])
def test_no_legend_lies_on_what_is_drawn(few, many, draw):
    for found in (few, many):
        figure = draw(found)
        figure.canvas.draw()
        assert figure.legends
        for axes in figure.axes:
            assert axes.get_legend() is None
            for legend in figure.legends:
                assert not legend.get_window_extent().overlaps(axes.get_window_extent())


def test_a_point_is_hollow_where_the_region_is_uncertain(few):
    unsure = replace(
        few[0], region=replace(few[0].region, probability=dict.fromkeys(CORNERS, 0.25))
    )
    (panel,) = panels_of(response_map([unsure, few[1]], 2.0))
    fills = [line.get_markerfacecolor() for line in panel.lines if line.get_marker() == "o"]
    assert fills.count("white") == 1


def test_motions_are_spread_over_all_and_have_a_unit(many):
    panels = response_motions(many).axes
    titles = [axes.get_title() for axes in panels if axes.get_title()]
    assert len(titles) == MOST
    assert titles[0].startswith("kp0,")
    assert titles[-1].startswith(f"kp{TOGETHER - 1},")
    assert panels[0].get_ylabel() == "position\n[rad or m]"
