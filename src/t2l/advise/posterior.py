"""What a few trainings say of all gains, with the predicted order as the prior.

The success of a cell is taken for

    f = a − b ln(e / e_least) + g,   a ~ N(A, S_A²),   g ~ N(0, S_G² exp(−d² / 2 L²)),

e being the predicted error and d the distance between cells in octaves of Kp and of Kd; a policy
trained there succeeds in f + N(0, S_P²) of its attempts. So a training tells of its neighbours too,
and a cell's policies are replicates. The next training is where the answer is expected to gain most
(expected improvement; Jones, Schonlau and Welch 1998).
Source: Rasmussen and Williams, Gaussian processes for machine learning, 2006, section 2.7.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from t2l.advise.exclusions import HOPELESS


@dataclass(frozen=True)
class Prior:
    """The numbers of the module's equation; success counts from 0 to 1, lengths are octaves."""

    middle: float
    slope: float
    spread: float
    own: float
    length: float
    policy: float


# fitted: by `python -m benchmarks advice`, most likely on the grids of ours whose policies were
# trained; it reports each by what the others fit
PRIOR = Prior(middle=0.72, slope=0.41, spread=0.09, own=0.14, length=1.2, policy=0.06)


@dataclass(frozen=True)
class Tried:
    """One policy: the cell that it was trained under, and its share of successes."""

    cell: int
    success: float


@dataclass(frozen=True)
class Posterior:
    """Of each cell's success, (cell,) and (cell, cell)."""

    mean: np.ndarray
    covariance: np.ndarray

    @property
    def deviation(self) -> np.ndarray:
        """(cell,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


@dataclass(frozen=True)
class Settled:
    """Policies that were trained, in that order, and what is believed since."""

    tried: tuple[Tried, ...]
    believed: Posterior


def posterior(
    score: np.ndarray,
    kp: np.ndarray,
    kd: np.ndarray,
    tried: Sequence[Tried] = (),
    prior: Prior = PRIOR,
) -> Posterior:
    """Of cells with a predicted error (cell,), the smaller the better.

    Args:
        kp, kd: (cell,) in any unit.
    """
    mean, covariance = before(score, kp, kd, prior)
    if not tried:
        return Posterior(mean, covariance)
    at = np.array([one.cell for one in tried])
    found = np.array([one.success for one in tried])
    seen = covariance[np.ix_(at, at)] + prior.policy**2 * np.eye(len(at))
    gain = np.linalg.solve(seen, covariance[at]).T
    return Posterior(mean + gain @ (found - mean[at]), covariance - gain @ covariance[at])


def before(
    score: np.ndarray, kp: np.ndarray, kd: np.ndarray, prior: Prior = PRIOR
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance without any training."""
    worse = np.log(np.minimum(score / score.min(), HOPELESS))
    places = np.log2(np.stack([kp, kd], axis=1))
    apart = ((places[:, None] - places[None]) ** 2).sum(axis=-1)
    own = prior.own**2 * np.exp(-apart / (2 * prior.length**2))
    return prior.middle - prior.slope * worse, prior.spread**2 + own


def next_cell(found: Posterior, left: np.ndarray) -> int:
    """Of the cells that are left (cell,), where a training is expected to gain most."""
    mean, deviation = found.mean, np.maximum(found.deviation, 1e-9)
    gain = (mean - mean[left].max()) / deviation
    expected = deviation * (gain * norm.cdf(gain) + norm.pdf(gain))
    return int(np.where(left, expected, -np.inf).argmax())


def best_cell(found: Posterior, left: np.ndarray) -> int:
    """Of the cells that are left (cell,), that of the greatest expected success."""
    return int(np.where(left, found.mean, -np.inf).argmax())
