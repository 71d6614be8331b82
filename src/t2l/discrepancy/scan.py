"""First guesses: every effect at a few magnitudes, on all joints at once, in one batch."""

from collections.abc import Sequence

import numpy as np

from t2l.discrepancy.evidence import some
from t2l.discrepancy.prediction import Predictor, Request
from t2l.effects.effect import Effect, Scales
from t2l.effects.term import Layout, Term

FEW = 2  # recordings on which directions are compared


def candidate_layout(adopted: Layout, effect: Effect, joints: int) -> Layout:
    """The adopted terms and `effect` on all joints."""
    others = [term for term in adopted.terms if term.effect.name != effect.name]
    return Layout([*others, Term(effect, tuple(range(joints)))])


def first_guesses(
    predictor: Predictor,
    mask: np.ndarray,
    adopted: Layout,
    u_adopted: np.ndarray,
    effects: Sequence[Effect],
) -> dict[str, tuple[Layout, np.ndarray, np.ndarray]]:
    """For each effect its layout with the adopted ones, a start u and the size of its elements.

    Each joint takes the guess that lowers its own error most, a parameter of the robot the one
    that lowers the whole error; where none helps, the mildest.
    """
    adopted_values = {
        name: {parameter: value[0] for parameter, value in parameters.items()}
        for name, parameters in adopted.decode(u_adopted[None]).items()
    }
    # directions are many: few recordings show which is best
    linear = [effect for effect in effects if effect.amplitudes]
    other = [effect for effect in effects if not effect.amplitudes]
    few, few_mask = some(predictor, mask, FEW)
    found = {}
    for group, where, at in ((other, predictor, mask), (linear, few, few_mask)):
        if group:
            found |= _scan(where, at, adopted, u_adopted, group, adopted_values, predictor.scales)
    return found


def _scan(
    predictor: Predictor,
    mask: np.ndarray,
    adopted: Layout,
    u_adopted: np.ndarray,
    effects: Sequence[Effect],
    adopted_values: dict,
    scales: Scales,
) -> dict[str, tuple[Layout, np.ndarray, np.ndarray]]:
    njoint, samples = len(predictor.joints), predictor.samples
    layouts = [candidate_layout(adopted, effect, njoint) for effect in effects]
    guesses = [effect.starts(scales) for effect in effects]
    requests = [
        Request(
            layout,
            np.array([layout.encode({**adopted_values, effect.name: s}) for s in starts]),
        )
        for effect, layout, starts in zip(effects, layouts, guesses, strict=True)
    ]
    base, *predicted = predictor.predict([Request(adopted, u_adopted[None]), *requests])
    residual = (base[0] - samples.q)[mask]
    joint = samples.joint[mask]
    found = {}
    for effect, layout, starts, q in zip(effects, layouts, guesses, predicted, strict=True):
        changed = (q - samples.q)[:, mask]
        values = _best(effect, starts, residual, changed, joint, njoint)
        size = _sizes(layout, effect, starts, adopted_values)
        found[effect.name] = (layout, layout.encode({**adopted_values, effect.name: values}), size)
    return found


def _best(effect, starts, residual, changed, joint, njoint) -> dict[str, np.ndarray]:
    if effect.amplitudes:
        return _best_combination(effect, starts, residual, changed, joint, njoint)
    squares = np.nan_to_num(changed**2, nan=np.inf)
    per_joint = np.stack([squares[:, joint == j].sum(axis=1) for j in range(njoint)], axis=1)
    whole = int(np.argmin(per_joint.sum(axis=1)))
    shared = [p for p in effect.parameters if not p.per_joint]
    allowed = np.array(
        [all(np.array_equal(s[p.name], starts[whole][p.name]) for p in shared) for s in starts]
    )
    choice = np.argmin(np.where(allowed[:, None], per_joint, np.inf), axis=0)
    values = {
        p.name: np.array(
            [np.broadcast_to(starts[choice[j]][p.name], njoint)[j] for j in range(njoint)]
        )
        if p.per_joint
        else starts[whole][p.name]
        for p in effect.parameters
    }
    for j in range(njoint):
        at = joint == j
        if per_joint[choice[j], j] >= (residual[at] ** 2).sum():
            share = _share(residual[at], changed[choice[j]][at] - residual[at])
            for p in effect.parameters:
                if p.per_joint and not p.log:
                    values[p.name][j] = p.neutral + share * (values[p.name][j] - p.neutral)
    return values


def _share(residual: np.ndarray, change: np.ndarray) -> float:
    """How much of a guess that overshoots to take, were the response linear in it."""
    size = float(change @ change)
    if not np.isfinite(size) or size == 0:
        return 0.05
    return float(np.clip(-(residual @ change) / size, 0.01, 1.0))


def _best_combination(effect, starts, residual, changed, joint, njoint) -> dict[str, np.ndarray]:
    """Starts that differ only in amplitudes are directions; the best sum of them per joint."""
    others = [p.name for p in effect.parameters if p.name not in effect.amplitudes]
    groups: dict[tuple, list[int]] = {}
    for i, start in enumerate(starts):
        key = tuple(np.round(start[name], 12).tobytes() for name in others)
        groups.setdefault(key, []).append(i)
    values = {p.name: np.empty(njoint) for p in effect.parameters}
    for j in range(njoint):
        at = joint == j
        best = np.inf
        for members in groups.values():
            directions = np.nan_to_num(changed[members][:, at] - residual[at]).T
            weight, *_ = np.linalg.lstsq(directions, -residual[at], rcond=None)
            left = float(((residual[at] + directions @ weight) ** 2).sum())
            if left < best:
                best = left
                for name in others:
                    values[name][j] = np.broadcast_to(starts[members[0]][name], njoint)[j]
                for name in effect.amplitudes:
                    values[name][j] = sum(
                        w * np.broadcast_to(starts[i][name], njoint)[j]
                        for w, i in zip(weight, members, strict=True)
                    )
    return values


def _sizes(layout: Layout, effect: Effect, starts, adopted_values) -> np.ndarray:
    """Magnitude of each element of u: of an adopted value, or of the first guesses."""
    sizes = []
    for slot in layout.slots:
        name = slot.parameter.name
        if slot.term.effect.name == effect.name:
            guesses = [np.broadcast_to(s[name], slot.term.width(slot.parameter)) for s in starts]
            at = slot.term.joints.index(slot.joint) if slot.joint is not None else 0
            sizes.append(np.median([abs(g[at]) for g in guesses]))
        else:
            sizes.append(np.abs(adopted_values[slot.term.effect.name][name]).mean())
    least = np.array([1e-4 * (s.parameter.upper - s.parameter.lower) for s in layout.slots])
    return np.maximum(np.array(sizes), np.minimum(least, 1e-2))
