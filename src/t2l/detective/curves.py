"""Curves as candidates: laws of one variable, each with as many numbers as the recordings tell.

A law is a spline over few intervals or over more. All its versions are combinations of the finest
basis, so that the responses to that one are enough. Every law is scored alone first, and on each
joint the best few go on to the screen, where they stand beside the known effects.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from t2l.detective.candidates import Candidate, Column, Responses, Table
from t2l.detective.linear_loop import Section
from t2l.detective.responses import added_torques
from t2l.detective.screen import Screen, products_of
from t2l.diagnose.conditions import features
from t2l.effects.effect import Scales
from t2l.effects.law import FRICTION, INERTIA, LIMIT, TENDON, Law
from t2l.effects.spline_torque import SplineTorque
from t2l.effects.term import Layout, Term
from t2l.identify.prediction import Predictor, Request
from t2l.propose.bases import SIZE, effect_of, straight, tendon_of, versions
from t2l.propose.laws import laws, lines, ranges
from t2l.propose.limits import limit_of
from t2l.propose.proposal import Ceiling
from t2l.propose.tendons import BETWEEN, measured, reach, table
from t2l.recordings.recording import Recording

LINE = 2  # format: numbers of a straight line
KEPT = 3  # numerics: laws of a joint that go on to the screen
BENDS = (1.0, 0.1, 0.01)  # numerics: of a curve, of which what is left out chooses
NEAR = 1.5  # numerics: times the least squared error of a law's versions, of a simpler one beside


def has_a_name(law: Law) -> bool:
    """Whether a known effect is the same: an offset, dry friction, an armature, a limit."""
    return law.follows == "constant" or law.kind in (INERTIA, LIMIT)


def is_named_line(effect: SplineTorque) -> bool:
    """Whether it is a line that known effects are too: a spring, viscous friction, a coupling."""
    return effect.basis.shape[1] <= LINE


def curves(
    predictor: Predictor,
    adopted: tuple[Layout, np.ndarray],
    residual: np.ndarray,
    sizes: Scales,
    named: bool = True,
    others: Sequence[Recording] = (),
) -> list[SplineTorque]:
    """Laws that the recordings vary, on joints that hold some of the error, at their finest.

    Args:
        residual: (nsample,) measured minus predicted, rad.
        named: leave out what a known effect is.
        others: recordings that the laws must also predict.
    """
    layout, u = adopted
    (q,), (dq,) = predictor.predict([Request(layout, u[None])], velocity=True)
    ends = ranges(predictor, q[0], dq[0], others)
    taken = {term.effect.name for term in layout.terms}
    free = {
        law: end for law, end in ends.items()
        if law.name not in taken and not (named and has_a_name(law))
    }  # fmt: skip
    motor = dict(zip(predictor.joints, sizes.torque, strict=True))
    only_lines, variables, found = lines(predictor), measured(predictor), []
    predicted = {"position": q[0], "velocity": dq[0]}
    for law, ratio in laws(predictor, residual, free, sizes.torque).items():
        if law.kind == LIMIT:
            at = predictor.samples.joint == predictor.joints.index(law.joint)
            commanded = features(predictor, q[0], dq[0])["torque"]
            found.append(limit_of(law, commanded[at], dq[0][at], SIZE * motor[law.joint]))
        elif law.kind == TENDON:
            pair = [predictor.joints.index(name) for name in (law.joint, law.of)]
            both = variables[law.follows], table(predictor, predicted[law.follows])
            x = [one[:, pair] for one in both]
            # the ratio may still move to the next
            near = [reach(x, ratio * times) for times in (1.0, 1 / BETWEEN, BETWEEN)]
            found.append(tendon_of(law, near, motor[law.joint], ratio))
        else:
            finest = effect_of(law, ends[law], motor[law.joint])
            found.append(straight(finest) if law in only_lines else finest)
    return [one for one in found if not (named and is_named_line(one))]


def with_curves(
    screened: Table,
    predictor: Predictor,
    sections: Sequence[Section],
    adopted: tuple[Layout, np.ndarray],
    finest: Sequence[SplineTorque],
    noise_rad: float,
    residual: np.ndarray,
    folds: np.ndarray,
    rows: np.ndarray,
    named: bool = True,
) -> tuple[Table, list[Ceiling]]:
    """A table with the best laws of each joint as candidates more; what each law alone promises.

    Args:
        finest: laws that are zero where their weights are.
        noise_rad: of a sample.
        residual: (k,) of the samples `rows`; folds: (k, n) of them, in n ways.
        named: leave out straight lines, which known effects are.
    """
    wanted = Responses(predictor, sections, rows)
    places = [_ask(wanted, predictor, sections, adopted, effect) for effect in finest]
    responses = wanted.responses()
    base, joints = screened.columns[:, list(screened.base)], predictor.samples.joint[rows]
    ceilings, whole = [], float(np.mean(residual**2))
    found: dict[int, list[tuple[float, list[tuple[Candidate, np.ndarray]]]]] = {}
    for effect, at in zip(finest, places, strict=True):
        joint = predictor.joints.index(effect.law.joint)
        made = _versions(effect, predictor.joints, len(screened.base), named)
        # what other joints lack is no reason to prefer a simple one
        here = np.isin(
            joints, [predictor.joints.index(n) for n in (effect.law.joint, effect.law.of)]
        )
        few = replace(
            screened,
            columns=np.zeros((int(here.sum()), 0), np.float32),
            candidates=[candidate for candidate, _ in made],
            base=tuple(range(len(screened.base))),
        )
        # all versions are combinations of the finest
        of_finest = block_diag(np.eye(base.shape[1]), np.hstack([of for _, of in made]), 1.0)
        every = np.column_stack([base, responses[:, at], residual])[here]
        products = of_finest.T @ products_of(every, folds[here]) @ of_finest
        alone = Screen(few, residual[here], folds[here], noise_rad, products)
        scored = alone.scores([(i,) for i in range(len(made))])
        best = min(scored, key=lambda s: s.error)
        # of all samples, as a tendon has those of two joints
        gain = (alone.score(()).error - best.error) * here.mean()
        simple = next(s for s in scored if s.error <= NEAR * best.error)
        kept = [
            (made[i][0], (responses[:, at] @ made[i][1]).astype(np.float32))
            for i in sorted({best.members[0], simple.members[0]})
        ]
        found.setdefault(joint, []).append((gain, kept))
        left = max(whole - max(gain, 0.0), 0.0)
        ceilings.append(Ceiling(effect.law, left**0.5))
    columns, candidates = [screened.columns], list(screened.candidates)
    count = screened.columns.shape[1]
    for laws_of_joint in found.values():
        for _, kept in sorted(laws_of_joint, key=lambda one: -one[0])[:KEPT]:
            for candidate, own in kept:
                first = candidate.columns[0].at
                candidates.append(candidate.moved(count - first))
                columns.append(own)
                count += own.shape[1]
    grown = replace(screened, columns=np.concatenate(columns, axis=1), candidates=candidates)
    return grown, sorted(ceilings, key=lambda one: one.rmse_rad)


def _ask(wanted: Responses, predictor, sections, adopted, effect: SplineTorque) -> list[int]:
    """Places of the responses to each basis function."""
    layout, u = adopted
    joint = predictor.joints.index(effect.law.joint)
    term = Term(effect, (joint,))
    whole = Layout([*layout.terms, term])
    known = {slot.key: value for slot, value in zip(layout.slots, u, strict=True)}
    start = np.array([known.get(slot.key, 0.0) for slot in whole.slots])
    weights = [effect.parameters[k].name for k in range(effect.basis.shape[1])]
    at = [i for i, s in enumerate(whole.slots) if s.term is term and s.parameter.name in weights]
    step = effect.parameters[0].size
    moved = np.repeat(start[None], len(at), axis=0)
    moved[np.arange(len(at)), at] += step
    if effect.law.kind == FRICTION:
        # what holds a joint at rest grows with friction from nothing, and no more soon after
        sections = [replace(s, path=replace(s.path, holds=False)) for s in sections]
    torques = [added_torques(predictor, s, adopted, [(whole, moved)])[0] for s in sections]
    on = None if effect.law.kind == TENDON else joint
    return [wanted.ask([t[:, k] / step for t in torques], on) for k in range(len(at))]


def _versions(
    finest: SplineTorque, joints: Sequence[str], first: int, named: bool
) -> list[tuple[Candidate, np.ndarray]]:
    """Candidates, the fewest numbers first, their columns numbered from `first` on.

    Each with its columns as combinations of the finest ones.
    """
    made, joint = [], joints.index(finest.law.joint)
    bent = [(one, of) for one, of in versions(finest) if not (named and is_named_line(one))]
    every = ((one.bending(bend), of) for one, of in bent for bend in BENDS)
    for effect, of_finest in every:
        parameters = effect.parameters
        columns = tuple(
            Column(first + k, parameters[k].name, joint, parameters[k].lower, parameters[k].upper)
            for k in range(of_finest.shape[1])
        )
        setting = {(p.name, joint): 0.0 for p in parameters}
        made.append((Candidate(effect, (joint,), setting, (), columns, len(parameters)), of_finest))
        first += of_finest.shape[1]
    return made
