"""Which joints show an effect: the fewest that explain what all do."""

from collections.abc import Sequence

import numpy as np

from t2l.effects.term import Layout, Term
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import NOTHING
from t2l.identify.prediction import Predictor, Request
from t2l.identify.uncertainty import Z95, uncertainty

# derived: of a joint's squared error that is left with an effect: without it no more
IDLE = (1 + NOTHING) ** 2


def without_idle_joints(
    name: str, fit: LeastSquares, predictor: Predictor, mask: np.ndarray
) -> LeastSquares | None:
    """A fit of effect `name` to the joints that show it alone; None if all do or none does."""
    term = next((t for t in fit.layout.terms if t.effect.name == name), None)
    if term is None:  # it was taken back
        return None
    shared = not any(p.per_joint for p in term.effect.parameters)
    if shared or len(term.joints) == 1 or fit.jacobian is None:
        return None
    found = uncertainty(fit, predictor, mask)
    keep = []
    for joint in term.joints:
        slots = [
            i for i, s in enumerate(fit.layout.slots)
            if s.term.effect.name == name and s.joint == joint
        ]  # fmt: skip
        if any(found.distance(i) > Z95 for i in slots):
            keep.append(joint)
    if any(
        p.log and not np.min(p.lower) <= p.neutral <= np.max(p.upper)
        for p in term.effect.parameters
    ):
        # absence is a limit, to which there is no distance in standard errors
        keep = _missed(term, keep, fit, predictor, mask)
    if not keep or len(keep) == len(term.joints):
        return None
    layout, index = _on_joints(fit.layout, term, keep)
    smaller = fit.again(layout, index)
    kept = {slot.key for slot in layout.slots}
    smaller.given = {key: column for key, column in fit.columns().items() if key in kept}
    return smaller


def _on_joints(layout: Layout, term: Term, joints: Sequence[int]) -> tuple[Layout, list[int]]:
    """`layout` with `term` on those joints only, and which elements of u are left."""
    smaller = [Term(t.effect, tuple(joints)) if t is term else t for t in layout.terms]
    index = [
        i for i, s in enumerate(layout.slots)
        if s.term is not term or s.joint is None or s.joint in joints
    ]  # fmt: skip
    return Layout(smaller), index


def _missed(
    term: Term, joints: Sequence[int], fit: LeastSquares, predictor: Predictor, mask: np.ndarray
) -> list[int]:
    """Those of `joints` that move differently without `term` on them, by their own error."""
    requests = []
    for joint in joints:
        others = [j for j in term.joints if j != joint]
        layout, index = _on_joints(fit.layout, term, others)
        requests.append(Request(layout, fit.u[None, index]))
    joint_of, missed = predictor.samples.joint[mask], []
    for joint, q in zip(joints, predictor.predict(requests), strict=True):
        at = joint_of == joint
        without = np.mean((q[0] - predictor.samples.q)[mask][at] ** 2)
        if not without <= IDLE * np.mean(fit.residual[at] ** 2):
            missed.append(joint)
    return missed
