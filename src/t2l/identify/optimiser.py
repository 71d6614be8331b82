"""What every optimiser of a fit is: it asks for points and is told the residuals there.

Optimisers that run together share their simulations: what all of them ask for in a round is one
batch. Two kinds come with t2l, `least_squares.LeastSquares` and `cma_es.CMAES`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np


class Optimiser(ABC):
    """Makes residuals small over a vector u.

    Attributes:
        u: (n,) the best so far.
        loss: there, infinite while nothing is known; mean squared residual if not said otherwise.
        iterations: rounds so far, less the one that looked at the start.
        starting: whether the next round looks at the start.
        done: whether more rounds would gain nothing.
    """

    u: np.ndarray
    loss: float
    iterations: int
    starting: bool
    done: bool

    @abstractmethod
    def points(self) -> np.ndarray:
        """(m, n) vectors u whose residuals are wanted next."""

    @abstractmethod
    def receive(self, residuals: np.ndarray, joints: np.ndarray) -> None:
        """Take the residuals (m, nsample) at `points`; `joints` (nsample,) are their joints."""


class Objective(ABC):
    """What is made small: simulated minus measured motion.

    Attributes:
        joints: (nsample,) index of the joint of each residual.
        recordings: how many there are, each of which begins anew.
    """

    joints: np.ndarray
    recordings: int = 1

    @abstractmethod
    def residuals(self, asked: Sequence[tuple[Optimiser, np.ndarray]]) -> list[np.ndarray]:
        """(m, nsample) for each optimiser's points (m, n); not finite where a simulation failed."""


def minimise(
    optimisers: Sequence[Optimiser],
    objective: Objective,
    iterations: int,
    after_round: Callable[[Sequence[Optimiser]], None] = lambda optimisers: None,
) -> None:
    """Advance `optimisers` together until each is done or has made `iterations` more.

    Args:
        after_round: called after each round with all of them, to report or to drop some.
    """
    last = [optimiser.iterations + iterations for optimiser in optimisers]
    while True:
        active = [
            o for o, stop in zip(optimisers, last, strict=True)
            if o.starting or not (o.done or o.iterations >= stop)
        ]  # fmt: skip
        if not active:
            return
        asked = [(optimiser, optimiser.points()) for optimiser in active]
        for optimiser, residuals in zip(active, objective.residuals(asked), strict=True):
            optimiser.receive(residuals, objective.joints)
        after_round(optimisers)
