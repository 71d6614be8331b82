"""How well data determine the parameters of a fit."""

from dataclasses import dataclass

import numpy as np

from t2l.effects.term import Layout
from t2l.identify.block_bootstrap import blocks
from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import TIED
from t2l.identify.prediction import Predictor

Z95 = 1.96  # statistics: of the normal distribution
RIDGE = 1e-12  # numerics: keeps what the data cannot tell apart at a huge, finite error
# derived: correlation of two estimates of which one alone explains as much as a tie
INSEPARABLE = (1 - TIED) ** 0.5
UNEXCITED = 1 / Z95  # derived: of the parameter's range, or of a unit of its logarithm


@dataclass(frozen=True)
class Uncertainty:
    """Standard errors of u (n,), infinite where the data say nothing.

    Attributes:
        correlation: (n, n) of the estimates.
    """

    layout: Layout
    u: np.ndarray
    error: np.ndarray
    correlation: np.ndarray

    def interval(self, i: int) -> tuple[float, float]:
        """95 % interval of parameter i itself, within its bounds."""
        low, high = self.u[i] - Z95 * self.error[i], self.u[i] + Z95 * self.error[i]
        wide = np.nan_to_num([low, high], nan=0.0, posinf=np.inf, neginf=-np.inf)
        bound = np.clip(wide, self.layout.lower[i], self.layout.upper[i])
        return tuple(float(np.exp(b) if self.layout.log[i] else b) for b in bound)

    def distance(self, i: int) -> float:
        """Standard errors between parameter i and the value at which its effect is absent.

        NaN where it is absent at none.
        """
        if not self.error[i] > 0:
            return 0.0
        return float(abs(self.u[i] - self.layout.neutral[i]) / self.error[i])

    def unexcited(self) -> list[int]:
        """Parameters that the data hardly determine."""
        width = np.where(self.layout.log, 1.0, self.layout.upper - self.layout.lower)
        return [i for i in range(len(self.u)) if not self.error[i] < UNEXCITED * width[i]]

    def inseparable(self) -> list[tuple[int, int]]:
        """Pairs of which the data determine only a combination."""
        n = len(self.u)
        return [
            (i, j)
            for i in range(n)
            for j in range(i + 1, n)
            if abs(self.correlation[i, j]) > INSEPARABLE
        ]


def uncertainty(fit: LeastSquares, predictor: Predictor, mask: np.ndarray) -> Uncertainty:
    """Sandwich estimate with blocks of time as clusters, since residuals are correlated in time.

    White, Asymptotic theory for econometricians, 1984, section VI.3.
    """
    samples = predictor.samples
    block = blocks(samples.recording[mask], samples.time[mask])
    jacobian, n = fit.jacobian, len(fit.u)
    norm = np.sqrt((jacobian**2).sum(axis=0))
    known = fit.free & (norm > 1e-9 * max(norm.max(initial=0.0), 1e-30))
    error, correlation = np.full(n, np.inf), np.eye(n)
    index = np.flatnonzero(known)
    if len(index):
        scaled = jacobian[:, index] / norm[index]
        inverse = np.linalg.inv(scaled.T @ scaled + RIDGE * np.eye(len(index)))
        score = scaled * fit.residual[:, None]
        sums = np.zeros((block.max() + 1, len(index)))
        np.add.at(sums, block, score)
        clusters = len(sums)
        robust = inverse @ (sums.T @ sums) @ inverse * clusters / max(clusters - 1, 1)
        plain = inverse * np.mean(fit.residual**2)
        covariance = np.maximum(np.diag(robust), np.diag(plain))
        error[index] = np.sqrt(covariance) / norm[index]
        root = np.sqrt(np.diag(inverse))
        correlation[np.ix_(index, index)] = inverse / np.outer(root, root)
    error[~fit.free] = 0.0
    return Uncertainty(fit.layout, fit.u, error, correlation)
