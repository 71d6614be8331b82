"""A search without derivatives, for effects whose error is rough in their parameters."""

from collections.abc import Sequence

import numpy as np

from t2l.discrepancy.fit import Fit
from t2l.discrepancy.prediction import Predictor, Request

GENERATIONS = 12
POPULATION = 12
SPREAD_LOG = 0.4  # standard deviation of the first generation in a logarithm


class _Strategy:
    """CMA-ES over the elements of u that belong to rough effects, in units of its spread."""

    def __init__(self, fit: Fit, seed: int):
        from cmaes import CMA  # with SciPy's statistics behind it, slow to import

        self.fit, self.origin = fit, fit.u.copy()
        self.index = np.array(
            [
                i
                for i, slot in enumerate(fit.layout.slots)
                if slot.term.effect.rough_error and not slot.parameter.rough
            ]
        )
        log = fit.layout.log[self.index]
        self.scale = np.where(log, SPREAD_LOG, 0.3 * fit.size[self.index])
        bounds = np.stack([fit.layout.lower, fit.layout.upper], axis=1)[self.index]
        bounds = (bounds - self.origin[self.index, None]) / self.scale[:, None]
        self.cma = CMA(
            np.zeros(len(self.index)), 1.0, bounds, seed=seed, population_size=POPULATION
        )

    def ask(self) -> np.ndarray:
        """(POPULATION, n) vectors u."""
        self.points = [self.cma.ask() for _ in range(POPULATION)]
        u = np.repeat(self.origin[None], POPULATION, axis=0)
        u[:, self.index] += self.scale * np.array(self.points)
        return u

    def tell(self, u: np.ndarray, losses: np.ndarray) -> None:
        """Take the losses of what was asked; the fit takes the best if it is better."""
        losses = np.where(np.isfinite(losses), losses, 1e3)
        self.cma.tell(list(zip(self.points, losses, strict=True)))
        best = int(np.argmin(losses))
        if losses[best] < self.fit.loss:
            self.fit.u, self.fit.loss = u[best], float(losses[best])
            self.fit.jacobian, self.fit.done = None, False


def search(fits: Sequence[Fit], predictor: Predictor, mask: np.ndarray, seed: int = 0) -> None:
    """Improve the parameters of rough effects in each fit by CMA-ES, all fits in one batch.

    Hansen, The CMA Evolution Strategy: A Tutorial, 2016. A fit's other parameters stay; its
    derivatives are forgotten where it moved.
    """
    measured = predictor.samples.q[mask]
    strategies = [_Strategy(fit, seed) for fit in fits]
    for _ in range(GENERATIONS if strategies else 0):
        asked = [strategy.ask() for strategy in strategies]
        requests = [Request(s.fit.layout, u) for s, u in zip(strategies, asked, strict=True)]
        predicted = predictor.predict(requests)
        for strategy, u, q in zip(strategies, asked, predicted, strict=True):
            strategy.tell(u, np.mean((q[:, mask] - measured) ** 2, axis=1))
