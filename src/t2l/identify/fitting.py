"""Effects fitted to recordings: optimisers whose points a `Predictor` simulates."""

from collections.abc import Callable, Hashable, Mapping, Sequence

import numpy as np

from t2l.identify.least_squares import LeastSquares
from t2l.identify.optimiser import Objective, Optimiser, minimise
from t2l.identify.prediction import Predictor, Request

ITERATIONS = 8  # tuned: bounds the time of a fit that does not settle


class PositionError(Objective):
    """Predicted minus measured position, rad, at some of a predictor's samples."""

    def __init__(self, predictor: Predictor, mask: np.ndarray):
        self.predictor, self.mask = predictor, mask
        self.recordings = len(predictor.recordings)
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
