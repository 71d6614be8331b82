"""What a person reads of a proposal says whether it held."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import TENDON, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.propose.proposal import LAW, NO_LAW, NOTHING, Learned, Proposal
from t2l.propose.wording import as_formulas, headline, told, variable
from tests.diagnose.made import pendulum


@pytest.fixture
def proposal(tmp_path):
    """A spring's curve, which took the error where it was chosen from 2 to 0.1 mrad."""
    curve = Curve(Law(TORQUE, "hinge", "position", "hinge"), (-1.0, 0.0, 1.0), (0.1, 0.0, -0.1))
    learned = Learned(curve, np.array(curve.torque), np.array(curve.torque))
    return Proposal(
        LAW, Model(pendulum(tmp_path)), ("hinge",), (learned,), 1e-4, 2e-3, 1e-4, 3e-3, 2e-4,
        (), ("a",), ("b",),
    )  # fmt: skip


def test_a_law_that_holds_on_unseen_recordings_is_what_lacks(proposal):
    assert "lacks a torque on hinge that falls with its position" in headline(proposal)
    assert "on unseen recordings falls from 3 to 0.2 mrad" in headline(proposal)


def test_a_law_that_does_not_hold_there_is_told_so(proposal):
    said = headline(replace(proposal, report_rmse_rad=4e-3))
    assert "lacks a" not in said
    assert "falls from" not in said
    assert "not on unseen recordings: there the error grows from 3 to 4 mrad" in said


def test_without_unseen_recordings_those_that_chose_are_named(proposal):
    said = headline(replace(proposal, report_baseline_rad=None, report_rmse_rad=None))
    assert "on what was left out falls from 2 to 0.1 mrad" in said


@pytest.mark.parametrize(
    ("ratio", "sum"), [(-0.8, "elbow − 0.8 shoulder"), (2.0, "elbow + 2 shoulder")]
)
def test_a_tendon_names_both_joints_and_how_they_add_up(ratio, sum):
    law = Law(TENDON, "elbow", "velocity", "shoulder")
    curve = Curve(law, (-1.0, 1.0), (0.1, -0.1), ratio)
    assert variable(curve) == f"velocity of {sum}"
    assert "on elbow and shoulder together that follows their velocities" in told(curve)


@pytest.mark.parametrize(
    ("verdict", "said"), [(NOTHING, "is noise"), (NO_LAW, "No law of one variable explains")]
)
def test_no_law_is_told_as_such(proposal, verdict, said):
    assert said in headline(replace(proposal, verdict=verdict))


@pytest.mark.parametrize(
    ("left_rad", "said"),
    [(None, ""), (2.02e-4, ""), (1e-4, "formula in place of the curve leaves 0.1")],
)
def test_what_a_formula_leaves_is_told_where_it_is_not_what_the_curve_leaves(
    proposal, left_rad, said
):
    assert said in (told := as_formulas(proposal, left_rad))
    assert bool(told) == bool(said)
