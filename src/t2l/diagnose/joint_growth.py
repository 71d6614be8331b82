"""An effect on the joints that show it: on one of them first, then on more while that pays.

What splits a joint in two cannot be absent from it by its parameters. On all joints at once, the
play of one would be paid for by the others, so a candidate is such an effect and a set of joints.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import ITERATIONS, LEADERS, run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import TIED
from t2l.identify.prediction import Predictor

# derived: joints alone, those with the largest part of the error; each takes a fit of its own
TRIED = LEADERS
PAYS = 1 - TIED  # derived: of the squared error that fewer joints leave

Key = tuple[str, tuple[int, ...]]  # an effect's name and its joints


def terms_to_try(
    effects: Sequence[Effect], adopted: Layout, predictor: Predictor, residual: np.ndarray
) -> list[Term]:
    """Every effect on all joints, and what splits joints on single ones beside those that have it.

    Args:
        residual: (nsample,) rad, of the model so far; NaN where it does not count.
    """
    njoint = len(predictor.joints)
    terms = [Term(effect, tuple(range(njoint))) for effect in effects]
    square = [np.nansum(residual[predictor.samples.joint == j] ** 2) for j in range(njoint)]
    worst = np.argsort(square)[::-1]
    for effect in filter(grows, effects):
        has = {j for t in adopted.terms if t.effect.name == effect.name for j in t.joints}
        for joint in [int(j) for j in worst if j not in has][:TRIED]:
            if len(has) + 1 < njoint:
                terms.append(Term(effect, tuple(sorted({*has, joint}))))
    return terms


def grows(effect: Effect) -> bool:
    """Whether it is tried on single joints."""
    return effect.extends and any(parameter.per_joint for parameter in effect.parameters)


def key_of(term: Term) -> Key:
    """What tells candidates apart."""
    return term.effect.name, term.joints


def on_the_joints_that_show_it(
    fits: Mapping[Key, LeastSquares], evidence: Evidence
) -> dict[str, LeastSquares]:
    """One fit of each effect, on as few joints as explain what more do, grown where that pays."""
    by_name: dict[str, list[LeastSquares]] = {}
    for (name, _), fit in fits.items():
        by_name.setdefault(name, []).append(fit)
    return {name: _best(name, candidates, evidence) for name, candidates in by_name.items()}


def _best(name: str, candidates: list[LeastSquares], evidence: Evidence) -> LeastSquares:
    everywhere, *few = candidates
    finite = sorted((fit for fit in few if np.isfinite(fit.loss)), key=lambda fit: fit.loss)
    if not finite:
        return everywhere
    grown, *others = finite
    for other in others:
        wider = united(name, grown, other)
        run([wider], evidence.screen, evidence.screen_mask, ITERATIONS)
        if wider.loss < PAYS * grown.loss:
            grown = wider
    return everywhere if everywhere.loss < PAYS * grown.loss else grown


def united(name: str, first: LeastSquares, second: LeastSquares) -> LeastSquares:
    """A fit of effect `name` to the joints of both, from where they ended; what both have of the
    first."""
    joints = {
        j for fit in (first, second) for t in fit.layout.terms if t.effect.name == name
        for j in t.joints
    }  # fmt: skip
    layout = Layout(
        Term(t.effect, tuple(sorted(joints))) if t.effect.name == name else t
        for t in first.layout.terms
    )
    u, size = {}, {}
    for fit in (second, first):
        for slot, value, scale in zip(fit.layout.slots, fit.u, fit.size, strict=True):
            u[slot.key], size[slot.key] = value, scale
    keys = [slot.key for slot in layout.slots]
    return LeastSquares(
        layout, np.array([u[k] for k in keys]), np.array([size[k] for k in keys]), first.diagonal,
        tolerance=first.tolerance, given=first.given,
    )  # fmt: skip
