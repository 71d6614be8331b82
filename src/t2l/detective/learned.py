"""The curves of a final model, with their bands, as a proposal that files and pages are made of."""

from dataclasses import replace

import numpy as np

from t2l.detective.data_split import DataSplit
from t2l.detective.fitted_set import FittedSet
from t2l.detective.search import Found
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout
from t2l.identify.model import Model, from_vector
from t2l.propose.band import band
from t2l.propose.laws import seen
from t2l.propose.proposal import LAW, NO_LAW, NOTHING, Learned, Proposal, error_of
from t2l.propose.shared_constants import anchoring


def splines(last: FittedSet) -> list[SplineTorque]:
    """Laws of a fitted model, as their splines."""
    effects = (term.effect for term in last.layout.terms)
    return [effect for effect in effects if isinstance(effect, SplineTorque)]


def final_model(model: Model, last: FittedSet, joints: tuple[str, ...]) -> Model:
    """`model` as it was fitted, with its curves; constants that these share stand in one of them.

    Args:
        model: as it came.
    """
    return from_vector(model, last.layout, _anchor(last) @ last.u, joints)


def proposal_of(came: Model, found: Found, data: DataSplit, quiet: bool) -> Proposal:
    """Curves of what was found, with bands, and the errors before and after.

    Args:
        quiet: whether the model as it came leaves only noise.
    """
    last, fitted, joints = found.last, data.fitted, data.fitted.joints
    laws, anchor = splines(last), _anchor(last)
    rows = found.rounds[-1].noise_rad * last.layout.prior
    everywhere = seen([fitted, data.test]) if laws else {}
    u, learned = anchor @ last.u, []
    for effect in laws:
        at = [i for i, s in enumerate(last.layout.slots) if s.term.effect.name == effect.name]
        anchored = replace(last, u=u)
        ends = band(anchored, effect, rows, fitted.samples, data.fitted_mask, anchor)
        learned.append(Learned(effect.curve(u[at]), *ends, everywhere.get(effect.law)))
    names = {effect.name for effect in laws}
    own = Layout([t for t in last.layout.terms if t.effect.name not in names])
    values = {slot.key: value for slot, value in zip(last.layout.slots, u, strict=True)}
    model = from_vector(came, own, np.array([values[s.key] for s in own.slots]), joints)
    before = error_of(came, fitted, data.fitted_mask)
    proposal = Proposal(
        LAW if learned else NOTHING if quiet else NO_LAW, model, joints, tuple(learned),
        found.rounds[-1].noise_rad, before, last.left_out_rmse, None, None,
        tuple(found.rounds[0].ceilings), tuple(r.name for r in fitted.recordings), (),
    )  # fmt: skip
    report, mask = data.test, data.test_mask
    return replace(
        proposal,
        report_baseline_rad=error_of(came, report, mask),
        report_rmse_rad=error_of(proposal.with_curves, report, mask),
        reported=tuple(r.name for r in report.recordings),
    )


def _anchor(last: FittedSet) -> np.ndarray:
    return anchoring(last.layout, splines(last), last.jacobian)
