"""What fits leave of each part of the samples when the others alone fit them.

A sample that is left out in several ways has the RMS of what is left of it. What a fold alone
tells, as of a motor at its limit in one recording, is left out by pieces of it.
"""

from collections.abc import Sequence

import numpy as np

from t2l.detective.candidates import FARTHEST
from t2l.detective.fitted_set import FittedSet, least_of_no_more
from t2l.detective.screen import ALIKE, bounded
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import HALF
from t2l.identify.optimiser import Objective
from t2l.identify.simulation import swinging

RIDGE = 1e-6  # numerics: of a column's sum of squares
DAMPINGS = (RIDGE, 0.01, 1.0)  # numerics: likewise, of steps to what fits without a part
PIECES = 4  # numerics: of what a fold alone tells
LONGER = 1.0  # numerics: samples' worth of squared error, by which a step may be too long
TINY = 1e-300  # numerics: of a column that does nothing
FAR = 1.5  # numerics: times the least error left out, beyond which the linear model tells it


def fitted(
    fits: Sequence[LeastSquares], objective: Objective, folds: np.ndarray, racing: bool = False
) -> list[FittedSet]:
    """Fits with what they leave on each fold when the others fit them; not those that ran away.

    Args:
        objective: that they were fitted by.
        racing: whether of those far behind one with no more effects the linear model tells it.
    """
    fits = [fit for fit in fits if np.isfinite(fit.loss) and fit.jacobian is not None]
    each = [_LeftOut(fit, folds) for fit in fits if fit.free.any()]
    near = _near(each) if racing else each
    for damping in DAMPINGS:
        some = [one for one in near if len(one.open)]
        asked = [(one.fit, one.points(damping)) for one in some]
        for one, residuals in zip(some, objective.residuals(asked), strict=True):
            one.receive(residuals)
    left = {id(one.fit): one.result() for one in each}
    found = []
    for fit in fits:
        left_out, told = left.get(id(fit), (fit.residual, np.ones(len(folds), bool)))
        if np.isfinite(left_out).all():
            found.append(
                FittedSet(
                    fit.layout, fit.u, fit.residual, left_out, told, fit.jacobian, fit.free,
                    objective.recordings * len(swinging(fit.layout.terms)),
                )
            )  # fmt: skip
    return found


def _near(each: Sequence["_LeftOut"]) -> list["_LeftOut"]:
    """Those that may be the nearest of no more effects; the others are as expected."""
    errors = [float(np.sqrt(np.mean(one.expected() ** 2))) for one in each]
    least = least_of_no_more(errors, [one.fit.layout for one in each])
    near = [one for one, e, best in zip(each, errors, least, strict=True) if e <= FAR * best]
    for one in near:
        one.left_out[:] = one.fit.residual[:, None]
    return near


class _LeftOut:
    """What a fit leaves of each part when the others fit it: a step of Gauss and Newton away.

    A step that makes the error of the others larger is too long, and a more damped one is tried
    (Marquardt, 1963). If none is shorter, the fit to all is that to the others too.

    Attributes:
        left_out: (nsample, k) rad, for each way to leave a sample out, as far as it is known; as
            fitted where the others do not tell it.
        told: (nsample, k) bool, where the others tell what the model says: to a standard error
            below that of a sample.
        parts: which samples are left out together, (nsample,) bool, in which of the ways, and of
            which that counts, (nsample,) bool.
        open: parts that no step is known for.
    """

    def __init__(self, fit: LeastSquares, folds: np.ndarray):
        self.fit, self.free = fit, np.flatnonzero(fit.free)
        jacobian, prior = fit.jacobian[:, self.free], fit.prior[:, self.free]
        self.size = np.sqrt((jacobian**2).sum(axis=0) + (prior**2).sum(axis=0)) + TINY
        self.jacobian, self.prior = jacobian / self.size, prior / self.size
        self.normal = self.jacobian.T @ self.jacobian + self.prior.T @ self.prior
        self.slope = self.jacobian.T @ fit.residual + self.prior.T @ (fit.prior @ fit.u)
        # what no part tells stays where it is
        values, directions = np.linalg.eigh(self.normal)
        held = directions[:, values < ALIKE]
        self.held = held @ held.T
        self.parts = [part for k in range(folds.shape[1]) for part in self._parts(folds[:, k], k)]
        self.told = np.zeros(folds.shape, bool)
        for _, k, counts in self.parts:
            self.told[counts, k] = True
        self.left_out = np.repeat(fit.residual[:, None], folds.shape[1], axis=1)
        self.open = [*range(len(self.parts))]

    def _parts(self, way: np.ndarray, k: int) -> list[tuple[np.ndarray, int, np.ndarray]]:
        """See `parts`."""
        folds = [way == fold for fold in np.unique(way)]
        counts = [self._tells(at) for at in folds]
        told = np.any(counts, axis=0)
        if told.mean() < HALF:
            return [(at, k, at) for at in folds]
        parts = [(at, k, of) for at, of in zip(folds, counts, strict=True)]
        for at in folds:
            for rows in np.array_split(np.flatnonzero(at & ~told), PIECES):
                piece = np.isin(np.arange(len(way)), rows)
                of = self._tells(piece)
                if of.any():
                    parts.append((piece, k, of))
        return parts

    def _tells(self, at: np.ndarray) -> np.ndarray:
        """(nsample,) bool of samples `at`, where all others tell what the model says."""
        told, mine = np.zeros(len(at), bool), self.jacobian[at]
        inverse = np.linalg.inv(self._others(mine, RIDGE))
        told[at] = np.einsum("ij,jk,ik->i", mine, inverse, mine, optimize=True) < 1
        return told

    def result(self) -> tuple[np.ndarray, np.ndarray]:
        """What is left (nsample,) of each sample in all ways, and where all of them are told."""
        if self.left_out.shape[1] == 1:
            return self.left_out[:, 0], self.told[:, 0]
        return np.sqrt(np.mean(self.left_out**2, axis=1)), self.told.all(axis=1)

    def _others(self, mine: np.ndarray, damping: float) -> np.ndarray:
        return self.normal - mine.T @ mine + damping * np.eye(len(self.free)) + self.held

    def points(self, damping: float) -> np.ndarray:
        """Parameters (nopen, n) that fit all but each of the open parts in turn."""
        fit, free = self.fit, self.free
        u, lower, upper = (x[free] for x in (fit.u, fit.layout.lower, fit.layout.upper))
        log = fit.layout.log[free]
        lower = np.where(log, np.maximum(lower, u - FARTHEST), lower)
        upper = np.where(log, np.minimum(upper, u + FARTHEST), upper)
        within = ((lower - u) * self.size, (upper - u) * self.size)
        # what the others alone say nothing of is not known there: it has no effect
        neutral = fit.layout.neutral[free]
        away = RIDGE * np.where(np.isfinite(neutral), u - neutral, 0.0) * self.size
        self._asked = []
        for part in self.open:
            at, _, _ = self.parts[part]
            mine = self.jacobian[at]
            target = mine.T @ fit.residual[at] - self.slope - away
            rest, found = self._others(mine, damping), fit.u.copy()
            found[free] += bounded(*(x[None] for x in (rest, target, *within)))[0] / self.size
            self._asked.append((part, found))
        return np.array([found for _, found in self._asked])

    def expected(self) -> np.ndarray:
        """What the linear model says is left (nsample,), which then is what is left out."""
        fit, points = self.fit, self.points(RIDGE)
        for (part, _), change in zip(self._asked, points - fit.u, strict=True):
            self._leave(part, fit.residual + fit.jacobian @ change)
        return self.result()[0]

    def _leave(self, part: int, residual: np.ndarray) -> None:
        """Take what is left of a part; one that the others tell better shows an unfinished fit."""
        _, k, counts = self.parts[part]
        if np.sum(residual[counts] ** 2) > np.sum(self.fit.residual[counts] ** 2):
            self.left_out[counts, k] = residual[counts]

    def receive(self, residuals: np.ndarray) -> None:
        """Take the residuals (nopen, nsample) at `points`; the first step that serves counts."""
        fit, done = self.fit, set()
        before = fit.residual**2
        for (part, u), residual in zip(self._asked, residuals, strict=True):
            at, _, _ = self.parts[part]
            known = np.sum((fit.prior @ fit.u) ** 2) - np.sum((fit.prior @ u) ** 2)
            least = before[~at].sum() + known + LONGER * fit.loss
            if np.sum(residual[~at] ** 2) <= least:
                self._leave(part, residual)
                done.add(part)
        self.open = [part for part in self.open if part not in done]
