"""What a person reads of a proposal says whether it held."""

from dataclasses import replace

import numpy as np
import pytest

from t2l.effects.law import TENDON, TORQUE, Curve, Law
from t2l.identify.model import Model
from t2l.propose.decision import Decision
from t2l.propose.found import Ceiling
from t2l.propose.proposal import LAW, NO_LAW, NOTHING, Learned, Proposal
from t2l.propose.reconsider import Reconsidered
from t2l.propose.wording import as_formulas, headline, part_of_it, retracted, told, variable
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
    assert "on the samples that chose falls from 2 to 0.1 mrad" in said


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


@pytest.mark.parametrize(("names_left_rad", "told"), [(1e-3, False), (1.9e-4, False), (5e-5, True)])
def test_a_law_that_replaced_names_is_compared_with_them(proposal, names_left_rad, told):
    proposal = replace(proposal, report_baseline_rad=names_left_rad)
    found = Reconsidered(proposal.model, proposal, ("cogging",), 3e-3, 1e-3, Decision(False, 0.3))
    said = retracted(found)
    assert "Cogging explains a third of the squared error" in said
    assert f"as it came leaves 3 mrad, with known effects {1e3 * names_left_rad:.3g}, and" in said
    assert "learned in place of cogging 0.2 (noise 0.1 mrad)" in said
    assert ("But known effects leave less there" in said) == told


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("cogging",), "Cogging explains about as much or less, and no more simply."),
        (
            ("cogging", "base_tilt"),
            "Cogging and base tilt explain about as much or less, and no more",
        ),
    ],
)
def test_names_that_a_simpler_law_replaced_are_told_as_such(proposal, names, said):
    assert said in retracted(Reconsidered(proposal.model, proposal, names, 3e-3, 1e-3, None))


def test_names_that_explain_a_part_are_told_as_that_beside_what_a_law_explains(proposal):
    proposal = replace(proposal, report_rmse_rad=1.5e-3)
    names = ("cogging", "base_tilt", "link_inertia")
    found = Reconsidered(proposal.model, proposal, (), 3e-3, 2e-3, None, names)
    said = part_of_it(found)
    assert "Cogging, base tilt and mass and inertia of a link explain only a part, 56 %" in said
    assert "2 of 3 mrad are left on unseen recordings (noise 0.1 mrad)" in said
    assert "falls with its position explains 75 % and leaves 1.5 mrad" in said
    ceiling = Ceiling(proposal.learned[0].curve.law, 1e-3, True)
    none = replace(proposal, verdict=NO_LAW, ceilings=(ceiling,))
    said = part_of_it(replace(found, proposal=none))
    assert "No law of one variable holds on other data either. The nearest is a torque on" in said
    assert "hinge that follows its position: 75 % of what it was chosen by." in said
