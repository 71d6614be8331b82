"""CMA-ES, an optimiser without derivatives, for losses that are rough in their parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from t2l.effects.term import Layout
from t2l.identify.optimiser import Optimiser

LARGEST = 1e9  # numerics: an infinite loss would poison the ranks' sum, a huge one only ranks last


def mean_square(residuals: np.ndarray) -> np.ndarray:
    """Of residuals (m, nsample), (m,); infinite where one is not finite."""
    mean = np.mean(residuals**2, axis=1)
    return np.where(np.isfinite(mean), mean, np.inf)


def default_population(numbers: int) -> int:
    """Points in a round for so many numbers (Hansen, The CMA Evolution Strategy, 2016, table 1)."""
    return 4 + int(3 * np.log(numbers))


@dataclass(frozen=True)
class Part:
    """Elements of u that are searched by themselves.

    Attributes:
        index: which, (k,).
        judged_by: the samples whose loss they answer for, (nsample,) bool or a slice.
    """

    index: np.ndarray
    judged_by: np.ndarray | slice


class CMAES(Optimiser):
    """Covariance matrix adaptation within bounds (Hansen, The CMA Evolution Strategy, 2016).

    Each of several parts has a population of its own in the same simulations, and the elements of
    no part stay. The search runs in x with u = origin + scale · x.
    """

    def __init__(
        self,
        u: np.ndarray,
        bounds: np.ndarray,
        sigma: float,
        population: int,
        seed: int,
        *,
        origin: np.ndarray | float = 0.0,
        scale: np.ndarray | float = 1.0,
        parts: Sequence[Part] | None = None,
        loss: Callable[[np.ndarray], np.ndarray] = mean_square,
        from_start: bool = True,
        layout: Layout | None = None,
    ):
        """Start at u (n,).

        Args:
            bounds: (n, 2) of u.
            sigma: standard deviation of the first population, in x.
            population: points in a round.
            parts: by default one of all elements, judged by all samples.
            loss: (m,) of residuals (m, nsample).
            from_start: look at the start first, so that nothing worse is ever found.
            layout: what u means, where a `Predictor` is to simulate it.
        """
        self.layout, self._size, self._loss_of = layout, population, loss
        self._start = np.asarray(u, float)
        every = Part(np.arange(len(self._start)), slice(None))
        origin, scale = (np.broadcast_to(v, self._start.shape) for v in (origin, scale))
        self._populations = [
            _Population(part, self._start, bounds, sigma, population, seed, origin, scale)
            for part in ([every] if parts is None else parts)
        ]
        self.iterations, self.starting, self.done = 0, from_start, False

    @property
    def u(self) -> np.ndarray:
        """The best elements of each part; where it starts if none was better."""
        u = self._start.copy()
        for population in self._populations:
            u[population.part.index] = population.best
        return u

    @property
    def loss(self) -> float:
        """The loss of the best, the mean of those of several parts."""
        return float(np.mean([population.loss for population in self._populations]))

    def points(self) -> np.ndarray:
        if self.starting:
            return self._start[None]
        points = np.repeat(self._start[None], self._size, axis=0)
        for population in self._populations:
            points[:, population.part.index] = population.ask()
        return points

    def receive(self, residuals: np.ndarray, joints: np.ndarray) -> None:
        for population in self._populations:
            losses = self._loss_of(residuals[:, population.part.judged_by])
            if self.starting:
                population.loss = float(losses[0])
            else:
                population.tell(losses)
        self.iterations += not self.starting
        self.starting = False


class _Population:
    """The points of one part, and the best of them so far."""

    def __init__(self, part, start, bounds, sigma, size, seed, origin, scale):
        from cmaes import CMA  # with SciPy's statistics behind it, slow to import

        index = part.index
        self.part, self.best, self.loss = part, start[index], np.inf
        self.origin, self.scale, self.size = origin[index], scale[index], size
        self.cma = CMA(
            (self.best - self.origin) / self.scale,
            sigma,
            (bounds[index] - self.origin[:, None]) / self.scale[:, None],
            seed=seed,
            population_size=size,
        )

    def ask(self) -> np.ndarray:
        """(size, k) values of the part's elements."""
        self.points = [self.cma.ask() for _ in range(self.size)]
        self.values = self.origin + self.scale * np.array(self.points)
        return self.values

    def tell(self, losses: np.ndarray) -> None:
        """Take the losses (size,) of what was asked."""
        self.cma.tell(list(zip(self.points, np.minimum(losses, LARGEST), strict=True)))
        first = int(np.argmin(losses))
        if losses[first] < self.loss:
            self.best, self.loss = self.values[first], float(losses[first])
