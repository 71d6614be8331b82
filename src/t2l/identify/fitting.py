"""Effects fitted to recordings: optimisers whose points a `Predictor` simulates."""

from collections.abc import Callable, Hashable, Mapping, Sequence

import numpy as np

from t2l.identify.least_squares import LeastSquares
from t2l.identify.levels import AT_THE_FLOOR, MATERIAL, PROMISING
from t2l.identify.optimiser import Objective, Optimiser, minimise
from t2l.identify.prediction import Predictor, Request

ITERATIONS = 8  # tuned: bounds the time of a fit that does not settle
REFINEMENTS = 3  # tuned: likewise, of one that begins near its end
LEADERS = 4  # tuned: of what looks best, on which more time is spent
# derived: relative gain of a round: with less, what is only promising is not the best after it
SLOW = 1 - 1 / PROMISING
# derived: after so many iterations, so many times the best loss, with a gain below this
HOPELESS = (
    (1, PROMISING**8, SLOW),
    (2, PROMISING**4, SLOW),
    (3, AT_THE_FLOOR**2, MATERIAL),
)


class PositionError(Objective):
    """Predicted minus measured position, rad, at some of a predictor's samples."""

    def __init__(self, predictor: Predictor, mask: np.ndarray):
        self.predictor, self.mask = predictor, mask
        self.measured, self.joints = predictor.samples.q[mask], predictor.samples.joint[mask]

    def residuals(self, asked):
        requests = [Request(optimiser.layout, points) for optimiser, points in asked]
        return [q[:, self.mask] - self.measured for q in self.predictor.predict(requests)]


def run(
    fits: Sequence[Optimiser],
    predictor: Predictor,
    mask: np.ndarray,
    iterations: int,
    after_round: Callable[[Sequence[Optimiser]], None] = lambda fits: None,
) -> None:
    """Advance `fits`, each with its `layout`, as `minimise` does.

    Args:
        mask: (nsample,) bool, the samples that are fitted.
    """
    minimise(fits, PositionError(predictor, mask), iterations, after_round)


def start_from_the_best(
    fits: Mapping[Hashable, LeastSquares],
    starts: Mapping[Hashable, np.ndarray],
    predictor: Predictor,
    mask: np.ndarray,
) -> None:
    """Let each fit begin at that of its starts (m, n) which leaves the least on the samples."""
    requests = [Request(fit.layout, starts[key]) for key, fit in fits.items()]
    for (key, fit), q in zip(fits.items(), predictor.predict(requests), strict=True):
        losses = np.mean((q - predictor.samples.q)[:, mask] ** 2, axis=1)
        fit.u = starts[key][int(np.argmin(np.nan_to_num(losses, nan=np.inf)))]


def drop_hopeless(fits: Sequence[LeastSquares], best: float | None = None) -> None:
    """End fits that several rounds have left far behind the best and that gain little more.

    Args:
        best: mean squared residual to compare with; by default the least of the fits.
    """
    best = max(min(fit.loss for fit in fits) if best is None else best, np.finfo(float).tiny)
    for fit in fits:
        behind = fit.loss / best
        if any(
            fit.iterations >= iterations and behind > much and fit.gain < little
            for iterations, much, little in HOPELESS
        ):
            fit.done = True


def least_loss(fits: Mapping[Hashable, LeastSquares]) -> float:
    """The least loss of several fits."""
    return min(fit.loss for fit in fits.values())
