"""A curve through noisy samples whose second derivative is constant between knots and jumps there.

So is the motion of a robot whose torque is held from tick to tick. It is a quadratic B-spline. Its
third differences are drawn from a Cauchy distribution, nearly all small and a few large, as torque
jumps where a command does or friction turns. The scale of these and the noise are those of greatest
marginal likelihood.

Source: Eilers and Marx, Flexible smoothing with B-splines and penalties, 1996; weights of the
differences by iteration, Lange, Little and Taylor, Robust statistical modeling using the t
distribution, 1989.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

# derived: (-1 + shift)³, of the coefficients of four basis functions
DIFFERENCE = np.array([-1.0, 3.0, -3.0, 1.0])
ORDER = len(DIFFERENCE) - 1  # derived: as many samples any parabola follows
EVERY = (1, 4, 16)  # numerics: ticks from knot to knot, that are tried
# numerics: variance of a sample over that of a difference: that are tried
RATIOS = np.geomspace(1e-2, 1e8, 6)
FINER = (0.1, 1.0, 10.0)  # numerics: likewise, times the best so far
ROUNDS = 6  # numerics: of weights of the differences
LEAST_RAD = 1e-9  # numerics: standard deviation of a sample, of which logarithms are taken
LOOKED_AT = 9  # numerics: places of which the standard error of the slope is the median


@dataclass(frozen=True)
class Curve:
    """Values and slopes at some times, and the standard error of a slope."""

    value: np.ndarray
    slope: np.ndarray
    slope_error: float


def p_spline(clock: np.ndarray, values: np.ndarray, at: np.ndarray) -> Curve | None:
    """The curve at evenly spaced times `at`; None if the samples are too few.

    Args:
        clock, values: (k,) samples, in order.
        at: (n,) times, which are ticks; before the first sample and after the last it stays.
    """
    inside = np.clip(at, clock[0], clock[-1]) if len(clock) else at
    if len(clock) <= ORDER + 1 or len(at) <= ORDER:
        return None
    period = at[1] - at[0]
    fits = [_Fit(clock - at[0], values, n * period, at[-1] - at[0]) for n in EVERY]
    fit = min((one for one in fits if one.tries(RATIOS)), key=lambda one: one.score, default=None)
    if fit is None:
        return None
    for _ in range(ROUNDS):
        fit.weigh()
        fit.tries(fit.ratio * np.array(FINER))
    value, slope = (fit.at(inside - at[0], derivative) for derivative in (0, 1))
    return Curve(value, np.where(at == inside, slope, 0.0), fit.slope_error(inside - at[0]))


class _Fit:
    """A spline with knots `step` apart from zero to `end`.

    Attributes:
        score: −2 log marginal likelihood of the best so far, up to a constant.
        ratio, coefficients: of the best.
        variance: of a sample, by the best.
        penalties: (m,) of each difference, one over the share of its variance.
    """

    def __init__(self, clock: np.ndarray, values: np.ndarray, step: float, end: float):
        self.step, self.values = step, values
        # numerics: of a quotient that is nearly a whole number
        self.intervals = max(int(np.ceil(end / step - 1e-6)), 1)
        self.count = max(self.intervals + 2, ORDER + 1)
        self.first, self.weights = self._basis(clock, 0)
        self.normal = _products(self.first, self.weights, np.ones(len(clock)), self.count)
        self.target = np.zeros(self.count)
        np.add.at(self.target, self.first[:, None] + np.arange(3), self.weights * values[:, None])
        self.penalties = np.ones(self.count - ORDER)
        self.score = np.inf

    def _basis(self, clock: np.ndarray, derivative: int) -> tuple[np.ndarray, np.ndarray]:
        """The first of three basis functions at times (k,), (k,), and their values, (k, 3)."""
        place = np.clip(clock / self.step, 0.0, self.intervals)
        first = np.minimum(place.astype(int), self.intervals - 1)
        x = place - first
        if derivative:
            return first, np.stack([x - 1, 1 - 2 * x, x], axis=1) / self.step
        return first, np.stack([(1 - x) ** 2 / 2, 0.5 + x - x**2, x**2 / 2], axis=1)

    def tries(self, ratios: np.ndarray) -> bool:
        """Take the best of some ratios; whether it is better than the best so far."""
        before, samples = self.score, len(self.values) - ORDER
        differ = np.tile(DIFFERENCE, (len(self.penalties), 1))
        rows = np.arange(len(self.penalties))
        penalty = _products(rows, differ, self.penalties, self.count)
        for ratio in ratios:
            whole = ratio * penalty
            whole[-len(self.normal) :] += self.normal
            try:
                factor = cholesky_banded(whole)
            except LinAlgError:
                continue
            found = cho_solve_banded((factor, False), self.target)
            left = self.values - self._sum(found, self.first, self.weights)
            moved = self._sum(found, rows, differ)
            square = left @ left + ratio * (self.penalties * moved**2).sum()
            variance = max(square / samples, LEAST_RAD**2)
            score = samples * np.log(variance) + 2 * np.log(factor[-1]).sum()
            score -= np.log(ratio * self.penalties).sum()
            if score < self.score:
                self.score, self.ratio, self.variance = score, ratio, variance
                self.coefficients, self.moved, self.factor = found, moved, factor
        return self.score < before

    def weigh(self) -> None:
        """Give differences that are large more variance than others; the mean share is one."""
        shares = 1 + self.ratio * self.moved**2 / self.variance
        self.penalties = np.exp(np.mean(np.log(shares))) / shares

    def at(self, clock: np.ndarray, derivative: int) -> np.ndarray:
        """Values (k,) at times, or slopes."""
        return self._sum(self.coefficients, *self._basis(clock, derivative))

    def slope_error(self, clock: np.ndarray) -> float:
        """The median standard error of the slope at some times."""
        some = clock[np.linspace(0, len(clock) - 1, LOOKED_AT).astype(int)]
        first, weights = self._basis(some, 1)
        unit = np.zeros((self.count, len(some)))
        for k in range(3):
            unit[first + k, np.arange(len(some))] += weights[:, k]
        square = (unit * cho_solve_banded((self.factor, False), unit)).sum(axis=0)
        return float(np.sqrt(self.variance * np.median(square)))

    @staticmethod
    def _sum(values: np.ndarray, first: np.ndarray, weights: np.ndarray) -> np.ndarray:
        return (weights * values[first[:, None] + np.arange(weights.shape[1])]).sum(axis=1)


def _products(first: np.ndarray, rows: np.ndarray, weights: np.ndarray, n: int) -> np.ndarray:
    """The upper band (m, n) of Σ w r rᵀ of rows (k, m), of which each begins at `first`."""
    width = rows.shape[1]
    band = np.zeros((width, n))
    for i in range(width):
        for j in range(i, width):
            values = weights * rows[:, i] * rows[:, j]
            band[width - 1 - (j - i)] += np.bincount(first + j, values, n)
    return band
