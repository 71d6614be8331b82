"""A search without derivatives, for effects whose error is rough in their parameters."""

from collections.abc import Sequence

import numpy as np

from t2l.identify.least_squares import Fit
from t2l.identify.prediction import Predictor, Request

GENERATIONS = 12
POPULATION = 12
SEED = 0
SPREAD_LOG = 0.4  # standard deviation of the first generation in a logarithm
SPREAD = 0.3  # likewise, of another parameter's own size


class _Strategy:
    """CMA-ES over some elements of a fit's u, in units of its first spread.

    Attributes:
        index: which elements.
        at: (nsample,) bool, the samples that judge them.
        best, loss: what was found, and its mean squared residual there.
    """

    def __init__(self, fit: Fit, index: np.ndarray, at: np.ndarray, spread: float):
        from cmaes import CMA  # with SciPy's statistics behind it, slow to import

        self.index, self.at = index, at
        self.origin, self.best, self.loss = fit.u[index], fit.u[index], np.inf
        scale = np.where(fit.layout.log[index], SPREAD_LOG, SPREAD * fit.size[index])
        self.scale = spread * scale
        bounds = np.stack([fit.layout.lower, fit.layout.upper], axis=1)[index]
        bounds = (bounds - self.origin[:, None]) / self.scale[:, None]
        self.cma = CMA(np.zeros(len(index)), 1.0, bounds, seed=SEED, population_size=POPULATION)

    def ask(self) -> np.ndarray:
        """(POPULATION, k) values of the elements."""
        self.points = [self.cma.ask() for _ in range(POPULATION)]
        return self.origin + self.scale * np.array(self.points)

    def tell(self, values: np.ndarray, squares: np.ndarray) -> None:
        """Take the squared residuals (POPULATION, nsample) of what was asked."""
        losses = _mean(squares[:, self.at])
        self.cma.tell(list(zip(self.points, losses, strict=True)))
        first = int(np.argmin(losses))
        if losses[first] < self.loss:
            self.best, self.loss = values[first], float(losses[first])


def search(
    fits: Sequence[Fit], predictor: Predictor, mask: np.ndarray, spread: float = 1.0
) -> list[np.ndarray]:
    """The best u (n,) that CMA-ES finds for the rough effects of each fit, all in one batch.

    Hansen, The CMA Evolution Strategy: A Tutorial, 2016. Where a fit moves all joints at once,
    each joint is searched by itself in the same simulations. A fit's other parameters stay, and
    all do where nothing better is found.

    Args:
        mask: (nsample,) bool, the samples that judge.
        spread: of the first generation, relative to what finds an effect from a first guess.
    """
    measured, joint = predictor.samples.q[mask], predictor.samples.joint[mask]
    searched = [(fit, _strategies(fit, joint, spread)) for fit in fits]
    start = predictor.predict([Request(fit.layout, fit.u[None]) for fit in fits])
    for (_, strategies), q in zip(searched, start, strict=True):
        for strategy in strategies:
            strategy.loss = float(_mean((q[:, mask] - measured)[:, strategy.at] ** 2)[0])
    for _ in range(GENERATIONS):
        asked, requests = [], []
        for fit, strategies in searched:
            u = np.repeat(fit.u[None], POPULATION, axis=0)
            for strategy in strategies:
                u[:, strategy.index] = strategy.ask()
            asked.append(u)
            requests.append(Request(fit.layout, u))
        predicted = predictor.predict(requests)
        for (_, strategies), u, q in zip(searched, asked, predicted, strict=True):
            squares = (q[:, mask] - measured) ** 2
            for strategy in strategies:
                strategy.tell(u[:, strategy.index], squares)
    return [_found(fit, strategies) for fit, strategies in searched]


def _strategies(fit: Fit, joint: np.ndarray, spread: float) -> list[_Strategy]:
    rough = [
        i
        for i, slot in enumerate(fit.layout.slots)
        if slot.term.effect.rough_error and not slot.parameter.rough
    ]
    everywhere = np.ones(len(joint), bool)
    if not fit.diagonal:
        return [_Strategy(fit, np.array(rough), everywhere, spread)]
    groups: dict[int | None, list[int]] = {}
    for i in rough:
        groups.setdefault(fit.layout.slots[i].joint, []).append(i)
    return [
        _Strategy(fit, np.array(index), everywhere if j is None else joint == j, spread)
        for j, index in groups.items()
    ]


def _found(fit: Fit, strategies: Sequence[_Strategy]) -> np.ndarray:
    u = fit.u.copy()
    for strategy in strategies:
        u[strategy.index] = strategy.best
    return u


def _mean(squares: np.ndarray) -> np.ndarray:
    """Mean over the samples, huge where a simulation ran away."""
    mean = np.mean(squares, axis=1)
    return np.where(np.isfinite(mean), mean, 1e3)
