"""The functions that a curve is a sum of: cubic B-splines with a penalty on their bends.

P-splines (Eilers and Marx, Flexible smoothing with B-splines and penalties, 1996): more knots than
the curve needs, and second differences of neighbouring weights kept small as far as other data say.
With a large penalty a curve becomes a straight line.

What is logged may stand still through a whole recording, so that only a few of its values are ever
seen. A curve over it is a broken line between those: no weight lacks data.
"""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import (
    FRICTION,
    GRID,
    HYSTERESIS,
    INERTIA,
    LIMIT,
    MOTOR,
    PHASE,
    TENDON,
    TORQUE,
    Curve,
    Law,
)
from t2l.effects.spline_torque import SplineTorque

INTERVALS = 18  # tuned: of a spline: four and a half periods of a ripple at four knots each
INTERVALS_OF_FRICTION = INTERVALS // 2  # derived: friction over speed has a dip and a slope
POINTS = 3  # numerics: of a table, in each interval
RADII = 10  # numerics: of a hysteresis, each half of the one before, from the range down
SIZE = 0.3  # numerics: of a joint's motor torque: what makes a difference
MARGIN = 0.05  # bound: of the range, to each side: the motion of a better model may go further


def effect_of(law: Law, ends: Sequence[float], motor_torque: float, finer: int = 1) -> SplineTorque:
    """A law with weights to fit.

    Args:
        ends: of its variable; of a logged one also where between them it was seen.
        motor_torque: N·m, that the joint's motor spends.
        finer: how many times as many intervals a spline has.
    """
    low, high = ends[0], ends[-1]
    size = SIZE if law.kind == MOTOR else SIZE * motor_torque
    if law.kind == HYSTERESIS:
        radii = (high - low) * 0.5 ** np.arange(RADII - 1, -1, -1)
        return SplineTorque(law, radii, np.eye(RADII), size)
    if law.follows == "constant":
        return constant(law, size)
    if law.kind == INERTIA:
        # one weight, in N·m at the largest acceleration
        grid = np.array([low, high])
        return SplineTorque(law, grid, -grid[:, None] / high, size)
    if law.given:
        grid = np.linspace(low, high, GRID)
        hats = [np.interp(grid, ends, one) for one in np.eye(len(ends))]
        return SplineTorque(law, grid, np.stack(hats, axis=1), size)
    if law.follows == PHASE:
        grid = np.linspace(low, high, GRID)
        return SplineTorque(law, grid, _cyclic(grid), size)
    margin = MARGIN * (high - low)
    begin = low if law.follows in ("speed", "commanded torque size", "time") else low - margin
    grid = np.linspace(begin, high + margin, GRID)
    count = finer * (INTERVALS_OF_FRICTION if law.kind == FRICTION else INTERVALS)
    # friction changes most where motion begins
    spread = np.linspace(0, 1, count + 1) ** (2 if law.follows == "speed" else 1)
    basis = _splines(grid, grid[0] + spread * (grid[-1] - grid[0]))
    return SplineTorque(law, grid, basis, size, shown=ends)


def tendon_of(
    law: Law, ends: Sequence[tuple[float, float]], motor_torque: float, ratio: float
) -> SplineTorque:
    """A tendon with weights to fit.

    Args:
        ends: of what it follows at `ratio`, and then at ratios that it may move to.
        motor_torque: as of `effect_of`.
        ratio: as of `SplineTorque`.
    """
    low, high = np.min(ends), np.max(ends)
    margin = MARGIN * (high - low)
    grid = np.linspace(low - margin, high + margin, GRID)
    basis = _splines(grid, np.linspace(grid[0], grid[-1], INTERVALS + 1))
    return SplineTorque(law, grid, basis, SIZE * motor_torque, shown=ends[0], ratio=ratio)


def constant(law: Law, size: float) -> SplineTorque:
    """A law whose torque is one weight; `size` as of `SplineTorque`."""
    return SplineTorque(law, np.array([0.0, 1.0]), np.ones((2, 1)), size)


def straight(effect: SplineTorque) -> SplineTorque:
    """A law as a straight line over the same grid; its weights are the torques at the ends."""
    to_the_end = np.linspace(0.0, 1.0, len(effect.grid))
    basis = np.stack([1 - to_the_end, to_the_end], axis=1)
    size = effect.parameters[0].size
    return SplineTorque(effect.law, effect.grid, basis, size, effect.shown, ratio=effect.ratio)


def may_be_straight(effect: SplineTorque) -> bool:
    """Whether a straight line may stand for it: of what is logged few values may have been seen."""
    law = effect.law
    told = law.kind != HYSTERESIS and law.follows != PHASE and not law.given
    return told and len(effect.parameters) > 2


def may_be_finer(effect: SplineTorque) -> bool:
    """Whether more knots can draw it better; a straight line has none."""
    law = effect.law
    drawn = law.kind == TORQUE and law.follows != PHASE and not law.given
    return drawn and len(effect.parameters) > 2


def _splines(grid: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """(g, k) cubic B-splines over `breaks`, not clamped where breaks are equally spaced."""
    from scipy.interpolate import BSpline

    first, last = breaks[1] - breaks[0], breaks[-1] - breaks[-2]
    steps = np.arange(1, 4)
    knots = np.concatenate([breaks[0] - first * steps[::-1], breaks, breaks[-1] + last * steps])
    return BSpline.design_matrix(np.clip(grid, breaks[0], breaks[-1]), knots, 3).toarray()


def _cyclic(grid: np.ndarray) -> np.ndarray:
    """(g, k) likewise, of curves that end as they begin and have no constant part."""
    basis = _splines(grid, np.linspace(grid[0], grid[-1], INTERVALS + 1))
    basis[:, :-INTERVALS] += basis[:, INTERVALS:]
    return basis[:, :INTERVALS] - basis[:-1, :INTERVALS].mean(axis=0)


def penalty(effect: SplineTorque) -> np.ndarray:
    """(m, k): the penalty is the sum of squares of this times the weights."""
    count = effect.basis.shape[1]
    if effect.law.kind == HYSTERESIS:
        return np.eye(count)
    if count == 1:
        return np.zeros((0, 1))
    if effect.law.given:
        step = np.diff(_knots(effect))
        slopes = np.diff(np.eye(count), axis=0) * (step.mean() / step)[:, None]
        return np.diff(slopes, axis=0)
    if effect.law.follows == PHASE:
        return np.roll(np.eye(count), 1, axis=0) - 2 * np.eye(count) + np.roll(np.eye(count), -1, 0)
    return np.diff(np.eye(count), 2, axis=0)


def tabulated(effect: SplineTorque, weights: np.ndarray, rest: Sequence[float] = ()) -> Curve:
    """The curve that weights (k,) make, over the range of the recordings.

    Args:
        rest: values of the parameters that are no weights.
    """
    law, grid = effect.law, effect.grid
    if law.kind == HYSTERESIS:
        at = np.concatenate([[0.0], grid])
        torque = -(np.minimum(at[:, None], grid) / grid) @ weights
        return Curve(law, tuple(at.tolist()), tuple(torque.tolist()))
    at = grid if len(grid) == 2 else grid[points(effect)]
    values = np.interp(at, grid, effect.basis @ weights)
    if law.kind == LIMIT:
        # beyond its no-load speed a motor brakes; at rest and against the motion none is driven
        until = np.searchsorted(at, 0.0) + 1
        values[:until] = np.maximum(values[:until], 0.0)
    at = at[0] + (at - at[0]) * (1 + (sum(rest) if law.follows == PHASE else 0.0))
    ratio = effect.ratio + (sum(rest) if law.kind == TENDON else 0.0)
    return Curve(law, tuple(at.tolist()), tuple(values.tolist()), ratio)


def points(effect: SplineTorque) -> np.ndarray:
    """Indices of the grid that a table shows: where the recordings were."""
    if effect.law.given:
        knots = _knots(effect)
        parts = np.arange(POINTS * (len(knots) - 1) + 1) / POINTS
        return np.round(np.interp(parts, np.arange(len(knots)), knots)).astype(int)
    first, last = np.searchsorted(effect.grid, effect.shown)
    count = POINTS * max(effect.basis.shape[1] - 3, 1) + 1
    return np.round(np.linspace(first, min(last, len(effect.grid) - 1), count)).astype(int)


def _knots(effect: SplineTorque) -> np.ndarray:
    """(k,) indices of the grid where a broken line breaks, and of its ends."""
    return effect.basis.argmax(axis=0)
