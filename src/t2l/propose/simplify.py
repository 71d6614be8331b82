"""Less in place of curves that were taken, or bent, only because something else was missing."""

from dataclasses import replace

import numpy as np

from t2l.effects.law import FRICTION, SIGNED, TENDON, TORQUE, Law
from t2l.effects.spline_torque import SplineTorque
from t2l.identify.prediction import Predictor
from t2l.propose.bases import constant, may_be_straight, straight
from t2l.propose.dictionary import rest_in, weights_in
from t2l.propose.found import Search, explain_alike
from t2l.propose.learning_samples import LearningSamples
from t2l.propose.refit import State, finish, off, refit, with_law, without
from t2l.propose.tendons import measured


def simplify(found: Search, limit_rad: float, samples: LearningSamples, draft: Predictor) -> None:
    """Take laws away in turn, or put less in their place, at no cost.

    Less is constants, of a tendon what acts on one joint alone, or a straight line.

    That is where the choosing samples are left with `limit_rad` at most; and where they tell no
    straight line from the curve.

    Args:
        draft: with coarser ticks, for all but the last steps of a fit.
    """
    predictor, fitted = samples.predictor, samples.fitted
    for curve in found.laws:
        trials = [
            without(found.state, [curve.name]),
            *levelled(found.state, curve, predictor.joints),
            *on_one_joint(found.state, curve, predictor),
            *straightened(found.state, curve, predictor.joints),
        ]
        shift = off(draft, found.state, found.residual)[fitted]
        finish(trials, refit(trials, draft, fitted, shift=shift), predictor, fitted)
        for trial, residual, error in zip(trials, *samples.left_by(trials), strict=True):
            # only a straight line is the same law
            is_line = curve.law in {effect.law for effect, _ in trial.laws}
            if error <= limit_rad and (
                not is_line or explain_alike(residual, found.residual, samples)
            ):
                found.put(predictor, trial, residual, error)
                break


def straightened(state: State, curve: SplineTorque, joints: tuple[str, ...]) -> list[State]:
    """The state with the straight line nearest to a curve in its place, if it may have one."""
    if not may_be_straight(curve):
        return []
    line, bare = straight(curve), without(state, [curve.name])
    torque = curve.basis @ state.u[weights_in(state.layout, curve)]
    first = np.linalg.lstsq(line.basis, torque, rcond=None)[0]
    first = first if curve.law.kind in SIGNED else np.maximum(first, 0.0)
    # two weights have no penalty
    made = with_law(bare, line, first, 1.0, joints)
    made.u[rest_in(made.layout, line)] = state.u[rest_in(state.layout, curve)]
    return [made]


def on_one_joint(state: State, curve: SplineTorque, predictor: Predictor) -> list[State]:
    """States with a law of one joint alone in place of a tendon that pulls little at the other.

    It begins where the other joint is on average: f(x_i + r x̄_j) on i, or r f(x̄_i + r x_j) on j.
    """
    if curve.law.kind != TENDON:
        return []
    ratio = curve.ratio + float(state.u[rest_in(state.layout, curve)].sum())
    weights = state.u[weights_in(state.layout, curve)]
    ((_, factor),) = (law for law in state.laws if law[0] is curve)
    mean = np.nanmean(measured(predictor)[curve.law.follows], axis=0)
    here, there = (mean[predictor.joints.index(name)] for name in (curve.law.joint, curve.law.of))
    first, second = (curve.law.joint, 1.0, ratio * there), (curve.law.of, ratio, here)
    joint, lever, other = first if abs(ratio) < 1 else second
    law = Law(TORQUE, joint, curve.law.follows, joint)
    if law in {other.law for other, _ in state.laws}:
        return []
    order = slice(None, None, 1 if lever > 0 else -1)
    grid, basis = ((curve.grid - other) / lever)[order], curve.basis[order]
    low, high = sorted((end - other) / lever for end in curve.shown)
    size = abs(lever) * curve.parameters[0].size
    effect = SplineTorque(law, grid, basis, size, (low, high))
    bare = without(state, [curve.name])
    # the same penalty of weights that are so many times as large
    return [with_law(bare, effect, lever * weights, factor / lever**2, predictor.joints)]


def levelled(state: State, curve: SplineTorque, joints: tuple[str, ...]) -> list[State]:
    """States with constants in place of a curve: a torque or dry friction, as it was, and both.

    Of a tendon they are on its first joint.

    The constant of its own kind begins at the mean of the curve. None for a single number.
    """
    law = curve.law
    if curve.basis.shape[1] == 1:
        return []
    mean = float(np.mean(curve.basis @ state.u[weights_in(state.layout, curve)]))
    there, bare = {other.law for other, _ in state.laws}, without(state, [curve.name])
    made = [bare]
    for kind in sorted((TORQUE, FRICTION), key=lambda kind: kind != law.kind):
        level = replace(law, kind=kind, follows="constant", of=law.joint)
        if level in there:
            continue
        effect = constant(level, curve.parameters[0].size)
        first = np.array([mean if kind == law.kind else 0.0])
        # one weight has no penalty
        made.append(with_law(made[-1], effect, first, 1.0, joints))
    return made[1:]
