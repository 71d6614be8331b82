"""The numbers of a final model, with intervals that hold what is true."""

import dataclasses
import json

import pytest

from t2l.detective.data_split import split
from t2l.diagnose.explanation import Explanation, Step, write_explanation
from t2l.diagnose.final_parameters import parameters_of
from t2l.diagnose.ranking import NOTHING_MISSING
from t2l.diagnose.result_types import Explanation as Content
from t2l.diagnose.result_types import read_content
from t2l.identify.model import Model
from t2l.identify.refit import refitted
from tests.diagnose.made import pendulum, swings

TRUE = {"coulomb_friction": {"torque": {"hinge": 0.05}}, "command_delay": {"delay": 0.02}}


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A model with effects, what they were fitted to, and which of its samples."""
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    data = split(robot, swings(robot, TRUE, noise_rad=3e-4), threads=1)
    begun = Model(
        robot, {"coulomb_friction": {"torque": {"hinge": 0.04}}, "command_delay": {"delay": 0.018}}
    )
    at = data.fitted, data.fitted_mask
    return refitted(begun, *at), *at


def test_intervals_hold_the_truth_around_the_values_of_the_model(fitted):
    final, *_ = fitted
    found = {row["effect"]: row for row in parameters_of(*fitted)}
    assert set(found) == set(TRUE)
    friction, delay = found["coulomb_friction"], found["command_delay"]
    assert (friction["joint"], friction["parameter"], friction["unit"]) == (
        "hinge", "torque", "N·m",
    )  # fmt: skip
    assert (delay["joint"], delay["unit"], delay["title"]) == (None, "s", "command delay")
    values = {
        "coulomb_friction": final.effects["coulomb_friction"]["torque"]["hinge"],
        "command_delay": final.effects["command_delay"]["delay"],
    }
    true = {"coulomb_friction": 0.05, "command_delay": 0.02}
    for name, row in found.items():
        low, high = row["ci95"]
        assert row["value"] == pytest.approx(values[name])
        assert low < row["value"] < high
        assert low < true[name] < high
        assert high - low < 0.2 * true[name]


def test_what_the_data_do_not_tell_has_no_interval(fitted):
    final, predictor, mask = fitted
    # at rest nothing slides
    still = [dataclasses.replace(r, q_des=0 * r.q_des, q=0 * r.q) for r in predictor.recordings]
    model = Model(final.robot, {"viscous_friction": {"damping": {"hinge": 0.01}}})
    (row,) = parameters_of(model, predictor.of(still), mask)
    assert row["ci95"] is None


def test_a_model_without_effects_has_none(fitted):
    final, *at = fitted
    assert parameters_of(Model(final.robot), *at) == []


def test_they_are_written_where_the_page_finds_them(fitted, tmp_path):
    rows = parameters_of(*fitted)
    steps = [
        Step((), 0.01, 0.01, 0.01),
        Step(("coulomb_friction",), 1e-4, 1e-4, 1e-4, (), ("friction",), (None,)),
    ]
    explanation = Explanation(steps, NOTHING_MISSING, 1e-4, "All is told.", fitted[0])
    write_explanation(explanation, tmp_path, rows)
    content = read_content(tmp_path / "explanation.json", Content, "an explanation")
    assert content["parameters"] == json.loads(json.dumps(rows))
