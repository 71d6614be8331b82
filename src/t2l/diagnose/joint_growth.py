"""An effect on the joints that show it: on one of them first, then on more while that pays.

What splits a joint in two cannot be absent from it by its parameters. On all joints at once, the
play of one would be paid for by the others, so a candidate is such an effect and a set of joints.
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from t2l.diagnose.evidence import Evidence
from t2l.diagnose.starting_points import begun, starting_points_of
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import ITERATIONS, LEADERS, drop_hopeless, least_loss, run
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import TIED

# derived: joints alone, those with the largest part of the error; each takes a fit of its own
TRIED = LEADERS
PAYS = 1 - TIED  # derived: of the squared error that fewer joints leave


def on_the_joints_that_show_it(
    fits: Mapping[str, LeastSquares], so_far: LeastSquares, evidence: Evidence
) -> dict[str, LeastSquares]:
    """Fits of effects on as few joints as explain what more do, where they grow.

    Args:
        fits: of every effect, on all joints.
        so_far: the model without them, on the same samples.
    """
    screen, mask = evidence.screen, evidence.screen_mask
    effects = {name: next(t.effect for t in fit.layout.terms if t.effect.name == name)
               for name, fit in fits.items()}  # fmt: skip
    square = np.full(len(screen.samples), 0.0)
    square[mask] = so_far.residual**2
    of_joints = [square[screen.samples.joint == j].sum() for j in range(len(screen.joints))]
    terms = single_joints(list(effects.values()), so_far.layout, of_joints)
    if not terms:
        return {}
    starts = starting_points_of(terms, screen, mask, so_far.layout, so_far.u)
    hopeless = partial(drop_hopeless, best=least_loss(fits))
    alone: dict[str, list[LeastSquares]] = {}
    for term, (start, _) in zip(terms, starts, strict=True):
        alone.setdefault(term.effect.name, []).append(begun(term, start, so_far))
    run([fit for few in alone.values() for fit in few], screen, mask, ITERATIONS, hopeless)
    alone = {name: sorted(few, key=lambda fit: fit.loss) for name, few in alone.items()}
    grown = {name: few[0] for name, few in alone.items() if np.isfinite(few[0].loss)}
    for place in range(1, TRIED):
        wider = {
            name: united(name, fit, alone[name][place])
            for name, fit in grown.items()
            if len(alone[name]) > place and np.isfinite(alone[name][place].loss)
        }
        run(list(wider.values()), screen, mask, ITERATIONS, hopeless)
        grown |= {n: fit for n, fit in wider.items() if fit.loss < PAYS * grown[n].loss}
    return {n: fit for n, fit in grown.items() if not fits[n].loss < PAYS * fit.loss}


def single_joints(
    effects: Sequence[Effect], adopted: Layout, squares: Sequence[float]
) -> list[Term]:
    """What splits joints, on single ones beside those that have it.

    Args:
        squares: (njoint,) what the model so far leaves of each joint, rad².
    """
    terms = []
    for effect in filter(grows, effects):
        has = {j for t in adopted.terms if t.effect.name == effect.name for j in t.joints}
        worst = [int(j) for j in np.argsort(squares)[::-1] if j not in has]
        if len(has) + 1 < len(squares):
            terms += [Term(effect, tuple(sorted({*has, joint}))) for joint in worst[:TRIED]]
    return terms


def grows(effect: Effect) -> bool:
    """Whether it is tried on single joints."""
    return effect.extends and any(parameter.per_joint for parameter in effect.parameters)


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
