"""The functions that a curve is a sum of: cubic B-splines over few intervals or over more.

Regression splines (Hastie et al., The elements of statistical learning, 2009, section 5.2): the
breaks of fewer intervals are among those of more, so that responses to the finest basis tell those
to all. How many intervals a curve has is chosen as any number of parameters is.

What is logged may stand still through a whole recording, so that only a few of its values are ever
seen. A curve over it is a broken line between those: no weight lacks data.
"""

from collections.abc import Sequence

import numpy as np

from t2l.effects.law import GRID, INERTIA, MOTOR, PHASE, Law
from t2l.effects.spline_torque import SplineTorque

RIPPLING, SMOOTH = 16, 8  # numerics: intervals at most: of what may ripple, of what acts smoothly
SIZE = 0.3  # numerics: of a joint's motor torque: what makes a difference
MARGIN = 0.05  # bound: of the range, to each side: the motion of a better model may go further
RIPPLES = ("position", PHASE)


def versions(finest: SplineTorque) -> list[tuple[SplineTorque, np.ndarray]]:
    """A law with fewer numbers and with all, the fewest first.

    Each comes with the (k, m) that makes its m basis functions of the finest's k.
    """
    law, size = finest.law, finest.parameters[0].size
    bases = [(finest.grid, finest.basis)]
    if finest.basis.shape[1] > 2 and law.follows != PHASE:
        bases.insert(0, (finest.grid, _straight(finest.grid)))
    if finest.breaks is not None:
        count = (len(finest.breaks) - 1) // 2
        # a cubic spline that comes again has four intervals or more
        while count > (3 if law.follows == PHASE else 1):
            every = (len(finest.breaks) - 1) // count
            basis = _over(law, finest.grid, finest.breaks[::every])
            bases.insert(-1, (finest.grid, basis))
            count //= 2
    bases.sort(key=lambda one: one[1].shape[1])
    return [
        (
            SplineTorque(law, grid, basis, size, finest.shown, ratio=finest.ratio),
            np.linalg.lstsq(finest.basis, basis, rcond=None)[0],
        )
        for grid, basis in bases
    ]


def effect_of(law: Law, ends: Sequence[float], motor_torque: float) -> SplineTorque:
    """A law with weights to fit, as many as the recordings may tell.

    Args:
        ends: of its variable; of a logged one also where between them it was seen.
        motor_torque: N·m, that the joint's motor spends.
    """
    low, high = ends[0], ends[-1]
    size = SIZE if law.kind == MOTOR else SIZE * motor_torque
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
    count = RIPPLING if law.follows in RIPPLES else SMOOTH
    if law.follows == PHASE:
        grid = np.linspace(low, high, GRID)
        return _spline(law, grid, np.linspace(low, high, count + 1), size)
    margin = MARGIN * (high - low)
    begin = low if law.follows in ("speed", "commanded torque size", "time") else low - margin
    grid = np.linspace(begin, high + margin, GRID)
    # friction changes most where motion begins
    spread = np.linspace(0, 1, count + 1) ** (2 if law.follows == "speed" else 1)
    return _spline(law, grid, grid[0] + spread * (grid[-1] - grid[0]), size, shown=(low, high))


def _spline(law: Law, grid, breaks, size: float, **others) -> SplineTorque:
    return SplineTorque(law, grid, _over(law, grid, breaks), size, breaks=breaks, **others)


def _over(law: Law, grid: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    return _cyclic(grid, breaks) if law.follows == PHASE else _splines(grid, breaks)


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
    breaks = np.linspace(grid[0], grid[-1], SMOOTH + 1)
    return _spline(law, grid, breaks, SIZE * motor_torque, shown=ends[0], ratio=ratio)


def constant(law: Law, size: float) -> SplineTorque:
    """A law whose torque is one weight; `size` as of `SplineTorque`."""
    return SplineTorque(law, np.array([0.0, 1.0]), np.ones((2, 1)), size)


def _straight(grid: np.ndarray) -> np.ndarray:
    """(g, 2) of a straight line, whose weights are the torques at the ends."""
    to_the_end = np.linspace(0.0, 1.0, len(grid))
    return np.stack([1 - to_the_end, to_the_end], axis=1)


def straight(effect: SplineTorque) -> SplineTorque:
    """A law as a straight line over the same grid; its weights are the torques at the ends."""
    size = effect.parameters[0].size
    return SplineTorque(
        effect.law, effect.grid, _straight(effect.grid), size, effect.shown, ratio=effect.ratio
    )


def _splines(grid: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """(g, k) cubic B-splines over `breaks`, not clamped where breaks are equally spaced."""
    from scipy.interpolate import BSpline

    first, last = breaks[1] - breaks[0], breaks[-1] - breaks[-2]
    steps = np.arange(1, 4)
    knots = np.concatenate([breaks[0] - first * steps[::-1], breaks, breaks[-1] + last * steps])
    return BSpline.design_matrix(np.clip(grid, breaks[0], breaks[-1]), knots, 3).toarray()


def _cyclic(grid: np.ndarray, breaks: np.ndarray) -> np.ndarray:
    """(g, k) likewise, of curves that end as they begin and have no constant part."""
    basis, count = _splines(grid, breaks), len(breaks) - 1
    basis[:, :-count] += basis[:, count:]
    return basis[:, :count] - basis[:-1, :count].mean(axis=0)
